// Whether outputs may be on: on by ENABLE, off by MUTE, by the watchdog and by the emergency stop. The latter two
// trip, until ENABLE or RESET.
`include "packets.vh"
`default_nettype none

module safety #(
    parameter UNIT_BITS = 6             // 2^n periods are a unit of the watchdog
) (
    input  wire        clk,
    input  wire        reset,
    input  wire        restart,         // RESET
    input  wire        count,           // a period more
    input  wire        boundary,
    input  wire        emergency,       // pressed, or not let go of since
    input  wire        good_packet,
    input  wire        enable,
    input  wire [15:0] enable_watchdog, // in units, 0: none
    input  wire        mute,
    output reg         enabled,
    output reg         tripped,
    output wire        forgotten        // at the boundary: no good packet for very long
);
    reg [15:0] watchdog;
    localparam QUIET_BITS = 16 + UNIT_BITS;
    localparam [QUIET_BITS-1:0] ONE = 1;
    reg [QUIET_BITS-1:0] quiet;     // periods since the last good packet, up to the largest number
    wire       late = watchdog != 16'd0 && quiet >= {watchdog, {UNIT_BITS{1'b0}}};

    assign forgotten = boundary && quiet[QUIET_BITS-1:`FALLBACK_BITS] != 0;

    always @(posedge clk) begin
        if (good_packet || restart) quiet <= {QUIET_BITS{1'b0}};
        else if (count && !(&quiet)) quiet <= quiet + ONE;

        if (mute) enabled <= 1'b0;
        if (enable) begin
            enabled <= 1'b1;
            tripped <= 1'b0;
            watchdog <= enable_watchdog;
        end
        if (restart) begin
            enabled <= 1'b0;
            tripped <= 1'b0;
            watchdog <= 16'd0;
        end
        if (emergency || (boundary && enabled && late)) begin
            enabled <= 1'b0;
            tripped <= 1'b1;
        end

        if (reset) begin
            enabled <= 1'b0;
            tripped <= 1'b0;
            watchdog <= 16'd0;
            quiet <= {QUIET_BITS{1'b0}};
        end
    end
endmodule

`default_nettype wire
