// player with any commands at any time: the slot stays within first and last (an assertion in player.v), it changes
// at boundaries only, a playing slot is busy, and commands in step or at a trigger are taken at such boundaries only.
`include "packets.vh"
`default_nettype none
module player_proof (
    input wire        clk,
    input wire        boundary,
    input wire        play,
    input wire [5:0]  first,
    input wire [5:0]  last,
    input wire [15:0] divider,
    input wire [15:0] loops,
    input wire [1:0]  when_asked,
    input wire        in_step,
    input wire        triggered,
    input wire        stop,
    input wire [5:0]  query
);
    reg reset = 1'b1;
    always @(posedge clk) reset <= 1'b0;

    wire       busy, several, waiting, waits_in_step, begins;
    wire [5:0] slot;
    player player (
        .clk(clk), .reset(reset), .boundary(boundary), .in_step(in_step), .triggered(triggered), .play(play), .play_first(first), .play_last(last),
        .play_divider(divider), .play_loops(loops), .play_when(when_asked), .play_begins(1'b1), .stop(stop),
        .query(query), .busy(busy), .slot(slot), .several(several), .waiting(waiting), .waits_in_step(waits_in_step), .begins(begins)
    );
    // As in the gate's proof.
    always @* if (play) assume (first <= last && divider != 16'd0);
    always @* if (play) assume (!boundary && !stop && !reset);

    reg [5:0] slot_before, query_before;
    reg       boundary_before, reset_before = 1'b1, play_before, busy_before, waited_before, in_step_before, stop_before;
    reg       for_trigger = 1'b0, waiting_before, triggered_before;
    always @(posedge clk) begin
        {slot_before, query_before, boundary_before, reset_before} <= {slot, query, boundary, reset};
        {play_before, busy_before} <= {play, busy};
        {waited_before, in_step_before, stop_before} <= {waits_in_step, in_step, stop};
        if (play) for_trigger <= when_asked == `WHEN_AT_TRIGGER;
        {waiting_before, triggered_before} <= {waiting, triggered};
    end
    always @(posedge clk) if (!reset && !reset_before) begin
        if (slot != slot_before) assert (boundary_before);
        if (query == slot) assert (busy);
        // The next slot was busy before: it cannot have been written in between.
        if (slot != slot_before && query_before == slot && !play_before) assert (busy_before);
        if (waited_before && !play_before && !stop_before) assert (boundary_before && in_step_before ? !waiting : waits_in_step);
        if (for_trigger && waiting_before && !play_before && !stop_before) assert (waiting == !(boundary_before && triggered_before));
        cover (for_trigger && waiting_before && !waiting && several);
        cover (waited_before && !waiting && boundary_before);
        cover (several && slot == 6'd5 && slot_before == 6'd4);
        cover (!several && waiting);
    end
endmodule
