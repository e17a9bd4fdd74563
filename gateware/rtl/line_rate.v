// The bit rate of the line: the power-up rate, the rate of BAUD once earlier answers have been sent, and the power-up
// rate again after a long time without a good packet.
`default_nettype none

module line_rate #(
    parameter [15:0] FIRST_INCREMENT = 16'd3200
) (
    input  wire        clk,
    input  wire        reset,
    input  wire        ask,         // for one clock: change to `asked`
    input  wire [15:0] asked,
    input  wire        answered,    // nothing is being answered
    input  wire        fall_back,
    output reg  [15:0] increment
);
    reg        waits;
    reg [15:0] next;

    always @(posedge clk) begin
        if (waits && answered) begin
            waits <= 1'b0;
            increment <= next;
        end
        if (ask) begin
            waits <= 1'b1;
            next <= asked;
        end

        if (reset || fall_back) begin
            waits <= 1'b0;
            increment <= FIRST_INCREMENT;
        end
    end
endmodule

`default_nettype wire
