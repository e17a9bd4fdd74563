// Reset until the clock has been good for 15 clocks, at power-up and after every loss; and the PLL's own reset: a PLL
// that loses its lock need not regain it by itself, so it is reset after 2^21 cycles of the oscillator without lock
// (50 to 80 ms), repeatedly.
`default_nettype none

module power_up (
    input  wire oscillator,
    input  wire clk,
    /* verilator lint_off SYNCASYNCNET */
    input  wire locked,     // used with a clock and without, on purpose
    /* verilator lint_on SYNCASYNCNET */
    output wire pll_reset,
    output wire reset
);
    reg [3:0] good = 4'd0;
    assign    reset = !(&good);
    always @(posedge clk or negedge locked) begin
        if (!locked) good <= 4'd0;
        else if (reset) good <= good + 4'd1;
    end

    // Only the oscillator is guaranteed to run.
    reg [20:0] waited = 21'd0;
    reg [1:0]  locked_inside = 2'd0;
    always @(posedge oscillator) begin
        locked_inside <= {locked_inside[0], locked};
        waited <= locked_inside[1] ? 21'd0 : waited + 21'd1;
    end
    // High for 16 cycles of the oscillator.
    assign pll_reset = &waited[20:4];
endmodule

`default_nettype wire
