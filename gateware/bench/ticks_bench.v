// ticks with all numbers of phase bits: the length of a period, the order of its events, and a change of banks when the
// lanes begin a period.
`include "check.vh"
module ticks_case #(parameter PHASE_BITS = 7, parameter PERIOD_BITS = 10) (input wire clk, input wire reset, output reg finished);
    integer errors = 0;
    wire last, count, boundary, sweep, gate, bank;
    wire [PERIOD_BITS-1:0] ahead;
    wire [PERIOD_BITS-1:0] tick;
    wire period_ends, skips;
    ticks #(.PERIOD_BITS(PERIOD_BITS), .PHASE_BITS(PHASE_BITS)) ticks (
        .clk(clk), .reset(reset), .hold(1'b0), .skip(1'b0), .skips(skips), .tick(tick), .period_ends(period_ends), .last(last), .count(count), .boundary(boundary), .sweep(sweep), .gate(gate),
        .ahead(ahead), .bank(bank)
    );

    localparam CLOCKS = 1 << PERIOD_BITS;
    integer periods = 0, since = 0, expected_ahead;
    reg     bank_before = 0;
    reg [PERIOD_BITS-1:0] ahead_before = 0;
    initial finished = 0;
    always @(negedge clk) if (!reset) begin
        if (periods > 0) begin
            `CHECK("count", count, since == 63)
            `CHECK("boundary", boundary, since == 64)
            `CHECK("sweep", sweep, since == 65)
            `CHECK("gate", gate, since == 350)
            `CHECK("tick", tick, since)
            `CHECK("the end of the lanes' period", period_ends, &ahead)
            `CHECK("last", last, since == CLOCKS - 1)
            // At tick 0, level 0 is already latched, three clocks after the lanes' tick.
            expected_ahead = (since + CLOCKS / (1 << PHASE_BITS) + 3) % CLOCKS;
            `CHECK("ahead", ahead, expected_ahead)
            `CHECK("a change of bank", bank != bank_before, ahead == 0)
        end else `CHECK("something before the first period", count || boundary || sweep || gate, 1'b0)
        bank_before = bank;
        since = last ? 0 : since + 1;
        if (last) periods = periods + 1;
        if (periods == 4) finished = errors == 0;
    end
endmodule

module ticks_bench;
    `include "bench.vh"
    reg reset = 1;
    wire [3:0] finished;
    ticks_case #(5, 10) five (clk, reset, finished[0]);
    ticks_case #(6, 10) six (clk, reset, finished[1]);
    ticks_case #(7, 10) seven (clk, reset, finished[2]);
    ticks_case #(8, 11) eight (clk, reset, finished[3]);
    initial begin
        repeat (3) @(negedge clk);
        #1 reset = 0;
        repeat (5 * 2048) @(negedge clk);
        `CHECK("finished", finished, 4'b1111)
        `END
    end
endmodule
