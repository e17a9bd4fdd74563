// follower and ticks behind a leader with its own clock, faster and slower than ours, at rest and while sounding:
// periods begin with the leader's, marks are recognised, and noise and periods of another length are rejected.
`include "check.vh"
`timescale 1ns/1ps
module follower_case #(
    parameter PHASE_BITS = 7,
    parameter PERIOD_BITS = 10,
    parameter real LEADER = 10.0    // ns, beside our 10
) (
    input wire clk, input wire reset, input wire still, input wire silent, input wire noise, output wire follows, output reg signed [31:0] off,
    output integer errors, output integer marks, output integer marks_seen
);
    localparam CLOCKS = 1 << PERIOD_BITS;
    localparam LEVEL = 1 << (PERIOD_BITS - PHASE_BITS);
    initial {errors, marks, marks_seen} = 0;
    // The leader: a counter.
    reg leader_clk = 0, leader_sync = 0, mark = 0;
    always #(LEADER / 2) leader_clk = !leader_clk;
    integer leader_tick = CLOCKS / 3;
    always @(posedge leader_clk) begin
        leader_tick = (leader_tick + 1) % CLOCKS;
        if (leader_tick == 0) mark = $random;
        leader_sync <= leader_tick < (mark ? 2 * LEVEL : LEVEL) && !silent;
    end
    wire sync_here;
    synchroniser synchroniser (.clk(clk), .reset(reset), .from_outside(leader_sync || noise), .synchronised(sync_here));

    wire hold, skip, skips, marked, last, count, boundary, sweep, gate, period_ends, bank;
    wire [PERIOD_BITS-1:0] tick, ahead;
    ticks #(.PERIOD_BITS(PERIOD_BITS), .PHASE_BITS(PHASE_BITS)) ticks (
        .clk(clk), .reset(reset), .hold(hold), .skip(skip), .skips(skips), .tick(tick), .last(last), .count(count),
        .boundary(boundary), .sweep(sweep), .gate(gate), .period_ends(period_ends), .ahead(ahead), .bank(bank)
    );
    follower #(.PERIOD_BITS(PERIOD_BITS), .PHASE_BITS(PHASE_BITS), .LATENCY(3)) follower (
        .clk(clk), .reset(reset), .sync_in(sync_here), .tick(tick), .still(still), .period_ends(period_ends),
        .boundary(boundary), .follows(follows), .marked(marked), .hold(hold), .skip(skip), .skipped(skips)
    );

    // Distance of our tick 0 from the leader's, and whether each boundary knows its mark.
    integer phase_of_leader, bank_changes = 0, clocks = 0, sounding = 0, alone = 0;
    reg bank_before = 0, sync_lately = 0;
    always @(negedge clk) if (!reset) begin
        if (tick == 0 && last !== 1'bx) begin
            phase_of_leader = leader_tick;
            off = phase_of_leader >= CLOCKS / 2 ? CLOCKS - phase_of_leader : -phase_of_leader;
        end
        // Alone, every period has the same length; following during sound, it differs by a level at most.
        clocks = clocks + 1;
        if (last && !hold) begin
            alone = follows ? 0 : alone + 1;
            if (alone > 2 && clocks != CLOCKS) errors = errors + 1;
            sounding = still ? 0 : sounding + 1;
            if (sounding > 2 && follows && (clocks > CLOCKS + LEVEL || clocks < CLOCKS - LEVEL)) errors = errors + 1;
            clocks = 0;
        end
        // A mark requires a recent edge of the leader.
        if (boundary && marked && !sync_lately) errors = errors + 1;
        sync_lately = boundary ? 0 : sync_lately || sync_here;
        if (boundary && follows && !silent && !noise) begin
            if (mark) marks = marks + 1;
            if (marked) marks_seen = marks_seen + 1;
            if (marked && !mark) errors = errors + 1;
        end
        // The banks change once in each period, also with a wait or a skipped level.
        if (bank !== bank_before) bank_changes = bank_changes + 1;
        bank_before = bank;
        if (boundary) begin
            if (bank_changes > 1) errors = errors + 1;
            bank_changes = 0;
        end
    end
endmodule

module follower_bench;
    `include "bench.vh"
    reg reset = 1, still = 1, silent = 1, noise = 0;
    wire [5:0] follows;
    wire other_follows;
    wire signed [31:0] other_off;
    wire [31:0] other_errors, other_marks, other_seen;
    wire signed [31:0] off_0, off_1, off_2, off_3, off_4, off_5;
    wire [31:0] errors_0, errors_1, errors_2, errors_3, errors_4, errors_5;
    wire [31:0] marks_0, marks_1, marks_2, marks_3, marks_4, marks_5, seen_0, seen_1, seen_2, seen_3, seen_4, seen_5;
    follower_case #(7, 10, 10.0) same (clk, reset, still, silent, noise, follows[0], off_0, errors_0, marks_0, seen_0);
    follower_case #(7, 10, 9.99) fast (clk, reset, still, silent, noise, follows[1], off_1, errors_1, marks_1, seen_1);
    follower_case #(7, 10, 10.01) slow (clk, reset, still, silent, noise, follows[2], off_2, errors_2, marks_2, seen_2);
    follower_case #(5, 10, 9.99) five (clk, reset, still, silent, noise, follows[3], off_3, errors_3, marks_3, seen_3);
    follower_case #(6, 10, 10.01) six (clk, reset, still, silent, noise, follows[4], off_4, errors_4, marks_4, seen_4);
    follower_case #(8, 11, 9.99) eight (clk, reset, still, silent, noise, follows[5], off_5, errors_5, marks_5, seen_5);
    // Periods of 1048 clocks are none.
    reg other_reset = 1;
    follower_case #(7, 10, 10.23) other (clk, other_reset, still, silent, noise, other_follows, other_off, other_errors, other_marks, other_seen);

    task periods(input integer n);
        repeat (2048 * n) @(negedge clk);
    endtask
    // Within one of the longest levels and two clocks of delay.
    task near;
        begin
            `CHECK("near, same clock", off_0 >= -2 && off_0 <= 2, 1'b1)
            `CHECK("near, leader fast", off_1 >= -10 && off_1 <= 10, 1'b1)
            `CHECK("near, leader slow", off_2 >= -10 && off_2 <= 10, 1'b1)
            `CHECK("near, 5 bits", off_3 >= -34 && off_3 <= 34, 1'b1)
            `CHECK("near, 6 bits", off_4 >= -18 && off_4 <= 18, 1'b1)
            `CHECK("near, 8 bits", off_5 >= -10 && off_5 <= 10, 1'b1)
        end
    endtask
    integer i;
    initial begin
        repeat (4) @(negedge clk);
        {reset, other_reset} = 2'b00;
        periods(4);
        `CHECK("follows no leader", follows, 6'd0)
        silent = 0;
        periods(6);
        `CHECK("follows", follows, 6'b111111)
        `CHECK("follows other periods", other_follows, 1'b0)
        other_reset = 1;
        for (i = 0; i < 20; i = i + 1) begin
            periods(1);
            near;
        end
        still = 0;
        for (i = 0; i < 50; i = i + 1) begin
            periods(1);
            near;
        end
        `CHECK("errors", errors_0 + errors_1 + errors_2 + errors_3 + errors_4 + errors_5, 0)
        `CHECK("marks", marks_0 > 20 && marks_1 > 20 && marks_2 > 20 && marks_3 > 20 && marks_4 > 20 && marks_5 > 20, 1'b1)
        `CHECK("marks seen", {seen_0, seen_1, seen_2, seen_3, seen_4, seen_5}, {marks_0, marks_1, marks_2, marks_3, marks_4, marks_5})
        // A spike is not taken for a period, and following continues.
        for (i = 0; i < 6; i = i + 1) begin
            repeat (2 * 2048 + 200 * i) @(negedge clk);
            noise = 1;
            repeat (2) @(negedge clk);
            noise = 0;
        end
        periods(4);
        `CHECK("follows in spite of noise", follows, 6'b111111)
        near;
        // Without the leader it continues alone; with the leader it returns during sound, by at most a level per
        // period.
        silent = 1;
        periods(12);
        `CHECK("follows no more", follows, 6'd0)
        silent = 0;
        periods(40);
        `CHECK("follows again", follows, 6'b111111)
        near;
        `CHECK("errors at the end", errors_0 + errors_1 + errors_2 + errors_3 + errors_4 + errors_5, 0)
        `END
    end
endmodule
