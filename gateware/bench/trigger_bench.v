// trigger: high for whole periods that begin a cycle while something sounds; a rising edge of the input counts once, at
// the next boundary.
`include "check.vh"
module trigger_bench;
    `include "bench.vh"
    reg  reset = 1, trigger_in = 1, boundary = 0, decide = 0, player_begins = 0, several = 0, modulation_begins = 0, last = 0, sounds = 0;
    wire triggered, trigger;
    trigger pins (
        .clk(clk), .reset(reset), .trigger_in(trigger_in), .boundary(boundary), .decide(decide), .player_begins(player_begins),
        .several(several), .modulation_begins(modulation_begins), .last(last), .sounds(sounds), .triggered(triggered), .trigger(trigger)
    );
    // A boundary of one period and the begin of the next, with other values in between.
    task period(input [3:0] what, input high, input edge_seen);
        begin
            boundary = 1;
            `CHECK("triggered at the boundary", triggered, edge_seen)
            @(negedge clk) {boundary, decide, player_begins, several, modulation_begins, sounds} = {2'b01, what};
            `CHECK("triggered after the boundary", triggered, 1'b0)
            @(negedge clk) {decide, player_begins, several, modulation_begins} = {1'b0, ~what[3:1]};
            repeat (3) @(negedge clk);
            last = 1;
            @(negedge clk) last = 0;
            `CHECK("trigger", trigger, high)
        end
    endtask
    initial begin
        repeat (2) @(negedge clk);
        reset = 0;
        // A high level is no edge.
        repeat (2) @(negedge clk);
        period(4'b0000, 0, 0);
        period(4'b1001, 1, 0);
        period(4'b1000, 0, 0);
        period(4'b1101, 1, 0);
        period(4'b0011, 1, 0);
        period(4'b0111, 0, 0);
        period(4'b0101, 0, 0);
        trigger_in = 0;
        repeat (2) @(negedge clk);
        trigger_in = 1;
        repeat (2) @(negedge clk);
        trigger_in = 0;
        repeat (2) @(negedge clk);
        period(4'b1001, 1, 1);
        period(4'b0001, 0, 0);
        `END
    end
endmodule
