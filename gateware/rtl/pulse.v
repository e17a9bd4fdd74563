// The rising level and the width in levels of a pulse, from its centre and its width in 1/256 period.
`include "packets.vh"
`default_nettype none

module pulse #(
    parameter PHASE_BITS = 7
) (
    input  wire [7:0]            middle,    // a delay of this of 256 parts of a period
    input  wire [7:0]            width_256,
    output wire [PHASE_BITS-1:0] rise,
    output wire [PHASE_BITS-1:0] width
);
    localparam [8:0] LEVEL = 1 << (8 - PHASE_BITS);     // in 1/256 period

    wire [8:0] capped = {1'b0, width_256 > `WIDEST ? `WIDEST : width_256};
    wire [8:0] rounded = capped + (LEVEL >> 1);
    // The centre of the pulse as it is played: the rise depends on the rounded width.
    wire [8:0] doubled = {middle, 1'b0} - (rounded & ~(LEVEL - 9'd1)) + LEVEL;

    assign rise = doubled[8:9-PHASE_BITS];
    assign width = rounded[7:8-PHASE_BITS];
    wire unused = &{1'b0, doubled, rounded};    // rounded off
endmodule

`default_nettype wire
