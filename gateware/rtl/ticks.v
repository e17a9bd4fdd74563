// Divides the clock into periods, and each period into what happens when:
//
//     tick 0      level 0 of the period appears at the registers
//     tick 3      a period more is counted
//     tick 4      boundary: watchdog, player, modulation
//     tick 5      the sweep over all channels begins
//     gate        it has ended, and one packet may take effect
//
// The lanes work ahead of the registers, by one level and their own three clocks; `bank` says which half of their memory they read.
`default_nettype none

module ticks #(
    parameter PERIOD_BITS = 10,     // 2^n clocks are a period
    parameter PHASE_BITS = 7,       // 2^n levels are a period
    parameter GATE = 288
) (
    input  wire                   clk,
    input  wire                   reset,
    output wire                   last,         // the next clock is tick 0
    output wire                   count,
    output wire                   boundary,
    output wire                   sweep,
    output wire                   gate,
    output reg  [PERIOD_BITS-1:0] ahead,        // the lanes' tick
    output reg                    bank
);
    localparam [PERIOD_BITS-1:0] LEAD = (1 << (PERIOD_BITS - PHASE_BITS)) + 3;
    localparam [PERIOD_BITS-1:0] ONE = 1;

    reg [PERIOD_BITS-1:0] tick;

    assign last     = &tick;
    assign count    = tick == 3;
    assign boundary = tick == 4;
    assign sweep    = tick == 5;
    assign gate     = tick == GATE;

    always @(posedge clk) begin
        tick <= tick + ONE;
        ahead <= ahead + ONE;
        if (&ahead) bank <= !bank;

        if (reset) begin
            tick <= -LEAD;
            ahead <= {PERIOD_BITS{1'b0}};
            bank <= 1'b0;
        end
    end
endmodule

`default_nettype wire
