// Detects the periods of another device, the leader, at `sync_in`, and determines the correction of our own periods:
// to wait at their end, or to skip a level.
`default_nettype none

module follower #(
    parameter PERIOD_BITS = 10,     // 2^n clocks are a period
    parameter PHASE_BITS = 7,       // 2^n levels are a period
    parameter LATENCY = 2           // clocks from the leader's tick 0 until `sync_in` is seen to rise here
) (
    input  wire                   clk,
    input  wire                   reset,
    input  wire                   sync_in,      // in our clock already
    input  wire [PERIOD_BITS-1:0] tick,
    input  wire                   still,        // nothing sounds: a period may wait for any time
    input  wire                   period_ends,  // the lanes' one, and it may wait
    input  wire                   boundary,
    output reg                    follows,      // `sync_in` carries periods
    output reg                    marked,       // until the boundary: the leader marks this period
    output wire                   hold,
    output reg                    skip,         // leave out the next period's last level
    input  wire                   skipped
);
    localparam [PERIOD_BITS:0] PERIOD = 1 << PERIOD_BITS;
    localparam [PERIOD_BITS-1:0] LEVEL = 1 << (PERIOD_BITS - PHASE_BITS);
    localparam [PERIOD_BITS-1:0] SEEN_AT = LATENCY;
    localparam [PERIOD_BITS:0] AROUND = 16;
    localparam [PERIOD_BITS:0] ONE = 1;
    localparam PATIENCE = 3;        // 2^n periods without a believed edge

    reg                            sync_before;
    reg [PERIOD_BITS:0]            since;       // the last edge, up to the largest number
    reg                            believed;    // the last edge came a period after the one before
    reg [PERIOD_BITS+PATIENCE-1:0] age;
    reg [PERIOD_BITS-1:0]          waits;

    wire edge_seen = sync_in && !sync_before;
    wire in_time = since >= PERIOD - AROUND && since <= PERIOD + AROUND;
    wire [PERIOD_BITS-1:0] early = tick - SEEN_AT;
    wire late = early[PERIOD_BITS-1];
    wire near = early <= 1 || early == {PERIOD_BITS{1'b1}};

    assign hold = period_ends && waits != {PERIOD_BITS{1'b0}};

    always @(posedge clk) begin
        sync_before <= sync_in;
        if (!(&since)) since <= since + ONE;
        if (!(&age)) age <= age + 1'b1;
        else follows <= 1'b0;

        if (edge_seen) begin
            since <= ONE;
            believed <= in_time;
        end
        if (boundary) marked <= 1'b0;
        // A mark is a pulse of two levels.
        if (believed && since == {1'b0, LEVEL + (LEVEL >> 1)}) marked <= sync_in;

        if (skipped) skip <= 1'b0;
        if (hold) waits <= waits - 1'b1;
        else if (edge_seen && in_time) begin
            age <= {PERIOD_BITS + PATIENCE{1'b0}};
            follows <= 1'b1;
            if (still) begin
                waits <= near ? {PERIOD_BITS{1'b0}} : early;
                skip <= 1'b0;
            end else begin
                waits <= late || near ? {PERIOD_BITS{1'b0}} : early < LEVEL ? early : LEVEL;
                skip <= late && early <= -LEVEL;
            end
        end

        if (reset) begin
            sync_before <= 1'b1;
            since <= {PERIOD_BITS + 1{1'b1}};
            believed <= 1'b0;
            follows <= 1'b0;
            marked <= 1'b0;
            waits <= {PERIOD_BITS{1'b0}};
            skip <= 1'b0;
            age <= {PERIOD_BITS + PATIENCE{1'b1}};
        end
    end
endmodule

`default_nettype wire
