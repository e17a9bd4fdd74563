// Writes the power-up content of the frame store and all tables, a cell per clock, after a reset and on request. It
// ends when the gate would open, so that no sweep runs.
`include "packets.vh"
`default_nettype none

module restore #(
    parameter SLOT_BITS = 6
) (
    input  wire                 clk,
    input  wire                 reset,
    input  wire                 start,
    input  wire                 open,
    output reg                  waking,     // since a reset: nothing is heeded yet
    output wire                 restored,   // for one clock
    output reg                  write,      // all zeros into the store at `place`; the tables' cells are at its lowest eight bits
    output reg  [SLOT_BITS+7:0] place,
    output reg  [7:0]           width
);
    localparam [SLOT_BITS+7:0] ONE = 1;
    localparam [2047:0] WIDTHS = `FIRST_WIDTHS;

    (* rom_style = "block", ram_style = "block" *)
    reg [7:0] widths [0:255];
    integer i;
    initial for (i = 0; i < 256; i = i + 1) widths[i] = WIDTHS[8*i +: 8];

    reg                 counting, ended;
    reg [SLOT_BITS+7:0] next;
    assign restored = ended && open;

    always @(posedge clk) begin
        width <= widths[next[7:0]];
        place <= next;
        write <= counting;
        next <= counting ? next + ONE : {SLOT_BITS + 8{1'b0}};
        if (&next) begin
            counting <= 1'b0;
            ended <= 1'b1;
        end
        if (start) counting <= 1'b1;
        if (restored) begin
            ended <= 1'b0;
            waking <= 1'b0;
        end

        if (reset) begin
            next <= {SLOT_BITS + 8{1'b0}};
            write <= 1'b0;
            counting <= 1'b1;
            ended <= 1'b0;
            waking <= 1'b1;
        end
    end
endmodule

`default_nettype wire
