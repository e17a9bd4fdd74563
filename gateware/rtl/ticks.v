// Divides the clock into periods, and each period into its events:
//
//     tick 0      level 0 of the period appears at the registers
//     tick 63     a period more is counted
//     tick 64     boundary: watchdog, player, modulation; it is known by then whether the leader marks the period
//     tick 65     the sweep over all channels begins
//     gate        it has ended, and one packet may take effect
//
// The lanes work ahead of the registers, by one level and their own three clocks; `bank` selects the half of their
// memory to read. A follower's lanes wait at the end of their period, or skip its last level.
`default_nettype none

module ticks #(
    parameter PERIOD_BITS = 10,     // 2^n clocks are a period
    parameter PHASE_BITS = 7,       // 2^n levels are a period
    parameter BOUNDARY = 64,
    parameter GATE = 350
) (
    input  wire                   clk,
    input  wire                   reset,
    input  wire                   hold,         // at the end of the lanes' period: wait
    input  wire                   skip,         // leave out the last level
    output wire                   skips,        // it is left out now
    output reg  [PERIOD_BITS-1:0] tick,
    output wire                   last,         // the next clock is tick 0
    output wire                   count,
    output wire                   boundary,
    output wire                   sweep,
    output wire                   gate,
    output wire                   period_ends,  // the lanes' one
    output reg  [PERIOD_BITS-1:0] ahead,        // the lanes' tick
    output reg                    bank
);
    localparam [PERIOD_BITS-1:0] LEVEL = 1 << (PERIOD_BITS - PHASE_BITS);
    localparam [PERIOD_BITS-1:0] LEAD = LEVEL + 3;
    localparam [PERIOD_BITS-1:0] ONE = 1;

    assign last        = &tick;
    assign count       = tick == BOUNDARY - 1;
    assign boundary    = tick == BOUNDARY;
    assign sweep       = tick == BOUNDARY + 1;
    assign gate        = tick == GATE;
    assign period_ends = &ahead;

    assign skips = skip && ahead == -LEVEL - ONE;

    always @(posedge clk) begin
        if (skips) begin
            tick <= tick + LEVEL + ONE;
            ahead <= {PERIOD_BITS{1'b0}};
        end else if (!hold) begin
            tick <= tick + ONE;
            ahead <= ahead + ONE;
        end
        if (skips || (period_ends && !hold)) bank <= !bank;

        if (reset) begin
            tick <= -LEAD;
            ahead <= {PERIOD_BITS{1'b0}};
            bank <= 1'b0;
        end
    end
endmodule

`default_nettype wire
