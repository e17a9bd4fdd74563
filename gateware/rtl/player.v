// The player of slots: one, or a range in a loop, by its own timer in periods. Commands wait for the next boundary,
// for the end of the running loop, for a boundary in step with other devices, or for a trigger.
`include "packets.vh"
`default_nettype none

module player #(
    parameter SLOT_BITS = 6
) (
    input  wire                 clk,
    input  wire                 reset,          // or RESET
    input  wire                 boundary,
    input  wire                 in_step,        // this boundary is
    input  wire                 triggered,      // since the boundary before
    input  wire                 play,
    input  wire [SLOT_BITS-1:0] play_first,
    input  wire [SLOT_BITS-1:0] play_last,
    input  wire [15:0]          play_divider,   // periods per slot
    input  wire [15:0]          play_loops,     // 0: for ever
    input  wire [1:0]           play_when,
    input  wire                 play_begins,    // it begins a cycle
    input  wire                 stop,
    input  wire [SLOT_BITS-1:0] query,
    output wire                 busy,           // the requested slot must not be written
    output reg  [SLOT_BITS-1:0] slot,
    output wire                 several,        // a range of more than one slot runs
    output reg                  waiting,
    output wire                 waits_in_step,
    output reg                  begins          // a clock after the boundary: a cycle begins
);
    reg                 running;
    reg [SLOT_BITS-1:0] first, last;
    reg [15:0]          divider, loops, left, wait_left;
    reg [SLOT_BITS-1:0] next_first, next_last;
    reg [15:0]          next_divider, next_loops;
    reg [1:0]           next_when;
    reg                 next_begins;

    localparam [SLOT_BITS-1:0] ONE = 1;
    wire slot_ends = running && wait_left == 16'd1;
    wire loop_ends = slot_ends && slot == last;
    wire over = loop_ends && loops != 16'd0 && left == 16'd1;
    wire due = next_when == `WHEN_IN_STEP ? in_step
        : next_when == `WHEN_AT_TRIGGER ? triggered
        : next_when == `WHEN_AT_ONCE || !running || loop_ends;
    wire take = waiting && due;
    assign waits_in_step = waiting && next_when == `WHEN_IN_STEP;

    assign several = running && first != last;
    assign busy = query == slot
        || (running && query >= first && query <= last)
        || (waiting && query >= next_first && query <= next_last);

    always @(posedge clk) begin
        if (boundary) begins <= take ? next_begins : several && loop_ends && !over;
        if (boundary && take) begin
            running <= 1'b1;
            waiting <= 1'b0;
            slot <= next_first;
            first <= next_first;
            last <= next_last;
            divider <= next_divider;
            wait_left <= next_divider;
            loops <= next_loops;
            left <= next_loops;
        end else if (boundary && running) begin
            wait_left <= slot_ends ? divider : wait_left - 16'd1;
            if (slot_ends && !loop_ends) slot <= slot + ONE;
            if (loop_ends) begin
                left <= left - 16'd1;
                if (over) running <= 1'b0;
                else slot <= first;
            end
        end

        if (stop) begin
            running <= 1'b0;
            waiting <= 1'b0;
        end
        if (play) begin
            waiting <= 1'b1;
            next_first <= play_first;
            next_last <= play_last;
            next_divider <= play_divider;
            next_loops <= play_loops;
            next_when <= play_when;
            next_begins <= play_begins;
        end

        if (reset) begin
            running <= 1'b0;
            waiting <= 1'b0;
            slot <= {SLOT_BITS{1'b0}};
            begins <= 1'b0;
        end
    end

`ifdef FORMAL
    always @* if (!reset && running) assert (first <= slot && slot <= last && wait_left != 16'd0 && wait_left <= divider);
    always @* if (!reset && waiting) assert (next_first <= next_last && next_divider != 16'd0);
`endif
endmodule

`default_nettype wire
