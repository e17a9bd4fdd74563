// line_rate: a new rate takes effect after all answers, and the line falls back to its first rate.
`include "check.vh"
module line_rate_bench;
    `include "bench.vh"
    reg         reset = 1, ask = 0, answered = 0, fall_back = 0;
    reg  [15:0] asked = 0;
    wire [15:0] increment;
    line_rate line_rate (
        .clk(clk), .reset(reset), .ask(ask), .asked(asked), .answered(answered), .fall_back(fall_back), .increment(increment)
    );
    initial begin
        repeat (2) @(negedge clk);
        reset = 0;
        @(negedge clk) `CHECK("the first rate", increment, 16'd3200)
        {ask, asked} = {1'b1, 16'd4800};
        @(negedge clk) {ask, asked} = {1'b0, 16'd7};
        repeat (50) @(negedge clk);
        `CHECK("the rate before the answer", increment, 16'd3200)
        answered = 1;
        @(negedge clk) `CHECK("the rate after it", increment, 16'd4800)
        repeat (5) @(negedge clk);
        `CHECK("the rate later", increment, 16'd4800)
        fall_back = 1;
        @(negedge clk) fall_back = 0;
        `CHECK("the rate when forgotten", increment, 16'd3200)
        repeat (5) @(negedge clk);
        `CHECK("the rate then", increment, 16'd3200)
        `END
    end
endmodule
