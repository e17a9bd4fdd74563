// The trigger output, high during the first period of a cycle, of the loop of slots or else of the modulation, while
// something is to be heard; and the trigger input, whose rising edge counts at the next boundary.
`default_nettype none

module trigger (
    input  wire clk,
    input  wire reset,
    input  wire trigger_in,         // in our clock already
    input  wire boundary,
    input  wire decide,             // after a boundary: whether its period begins a cycle
    input  wire player_begins,
    input  wire several,
    input  wire modulation_begins,
    input  wire last,               // the next clock is level 0 of the period that the sweep has prepared
    input  wire sounds,
    output reg  triggered,          // until the boundary
    output reg  trigger
);
    reg was_high, begins;

    always @(posedge clk) begin
        was_high <= trigger_in;
        if (boundary) triggered <= 1'b0;
        if (trigger_in && !was_high) triggered <= 1'b1;
        if (decide) begins <= player_begins || (modulation_begins && !several);
        if (last) trigger <= begins && sounds;

        if (reset) begin
            was_high <= 1'b1;
            triggered <= 1'b0;
            begins <= 1'b0;
            trigger <= 1'b0;
        end
    end
endmodule

`default_nettype wire
