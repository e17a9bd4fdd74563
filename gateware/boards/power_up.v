// Reset until the clock has been good for 15 clocks, at power-up and whenever it was lost.
`default_nettype none

module power_up (
    input  wire clk,
    input  wire locked,
    output wire reset
);
    reg [3:0] good = 4'd0;
    assign    reset = !(&good);
    always @(posedge clk or negedge locked) begin
        if (!locked) good <= 4'd0;
        else if (reset) good <= good + 4'd1;
    end
endmodule

`default_nettype wire
