// The shift registers' output enable: on for whole periods, those for which the sweep before them found something to
// be heard; off at once and asynchronously with an emergency stop.
`default_nettype none

module outputs (
    input  wire clk,
    input  wire reset,
    input  wire last,       // the next clock is level 0 of a period
    input  wire sounds,     // something is to be heard in it
    input  wire caught,     // an emergency stop, not released
    input  wire estop_n,
    output reg  on,
    output wire oe_n
);
    assign oe_n = !on || caught || !estop_n;

    always @(posedge clk) begin
        if (last) on <= sounds;
        if (reset) on <= 1'b0;
    end
endmodule

`default_nettype wire
