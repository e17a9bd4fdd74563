// player: slots for a number of periods each, loops and their beginnings, waiting commands, and busy slots.
`include "check.vh"
module player_bench;
    `include "bench.vh"
    reg         reset = 1, boundary = 0, play = 0, stop = 0, in_step = 0, triggered = 0, is_play = 1;
    reg  [5:0]  first = 0, last = 0, query = 0;
    reg  [15:0] divider = 0, loops = 0;
    reg  [1:0]  when_asked = 0;
    wire        busy, several, waiting, waits_in_step, begins;
    wire [5:0]  slot;
    player player (
        .clk(clk), .reset(reset), .boundary(boundary), .in_step(in_step), .triggered(triggered), .play(play), .play_first(first), .play_last(last),
        .play_divider(divider), .play_loops(loops), .play_when(when_asked), .play_begins(is_play), .stop(stop),
        .query(query), .busy(busy), .slot(slot), .several(several), .waiting(waiting),
        .waits_in_step(waits_in_step), .begins(begins)
    );

    task period(input [5:0] expected);
        begin
            boundary = 1;
            @(negedge clk) boundary = 0;
            @(negedge clk) `CHECK("the slot", slot, expected)
        end
    endtask
    task ask(input [5:0] from, input [5:0] to, input [15:0] each, input [15:0] times, input [1:0] at);
        begin
            {first, last, divider, loops, when_asked} = {from, to, each, times, at};
            play = 1;
            @(negedge clk) play = 0;
            `CHECK("waiting", waiting, 1'b1)
        end
    endtask
    // Whether this period begins a cycle.
    task beginning(input [5:0] expected, input whether);
        begin
            period(expected);
            `CHECK("begins", begins, whether)
        end
    endtask
    // Only the slots from `from` to `to` are busy, besides the playing one.
    task busy_in(input integer from, input integer to);
        integer i;
        for (i = 0; i < 64; i = i + 1) begin
            query = i;
            #1 `CHECK("busy", busy, (i >= from && i <= to) || i == slot)
        end
    endtask

    integer i;
    initial begin
        repeat (2) @(negedge clk);
        reset = 0;
        period(0);
        busy_in(0, 0);
        // Twice over 3, 4, 5 with two periods each; then the last slot stays.
        ask(3, 5, 2, 2, 0);
        busy_in(3, 5);
        repeat (2) begin
            for (i = 3; i <= 5; i = i + 1) begin
                period(i);
                `CHECK("several", several, 1'b1)
                period(i);
            end
        end
        period(5);
        `CHECK("several at the end", several, 1'b0)
        busy_in(5, 5);
        // Endlessly; later commands wait for the end of the loop, and newer ones replace them.
        ask(8, 9, 1, 0, 1);
        period(8);
        period(9);
        period(8);
        ask(20, 20, 1, 0, 1);
        ask(30, 31, 3, 1, 1);
        `CHECK("busy beyond what waits", busy, 1'b0)
        query = 31;
        #1 `CHECK("busy while waiting", busy, 1'b1)
        period(9);
        period(30);
        `CHECK("waiting still", waiting, 1'b0)
        period(30);
        // At once, in the middle of a slot.
        ask(40, 40, 1, 0, 0);
        period(40);
        `CHECK("several of one", several, 1'b0)
        period(40);
        // STOP cancels a waiting command and stays.
        ask(50, 55, 7, 0, 1);
        stop = 1;
        @(negedge clk) stop = 0;
        `CHECK("waiting after STOP", waiting, 1'b0)
        repeat (20) period(40);
        busy_in(40, 40);
        // The longest slot.
        ask(1, 2, 16'hFFFF, 1, 0);
        repeat (65535) period(1);
        repeat (65535) period(2);
        repeat (3) period(2);
        // The last slot of the store, and back.
        ask(62, 63, 1, 0, 0);
        repeat (3) begin
            period(62);
            period(63);
        end
        // In step: the command waits for such a boundary, whatever runs or ends.
        ask(7, 8, 2, 0, 2);
        `CHECK("waiting in step", waits_in_step, 1'b1)
        repeat (3) begin
            period(62);
            period(63);
        end
        ask(9, 9, 1, 1, 2);
        period(62);
        in_step = 1;
        period(9);
        `CHECK("waiting in step still", waits_in_step, 1'b0)
        // A boundary in step only takes commands waiting for it.
        ask(10, 11, 1, 0, 0);
        period(10);
        ask(20, 20, 1, 0, 1);
        `CHECK("waiting for the loop", waits_in_step, 1'b0)
        period(11);
        period(20);
        in_step = 0;
        // An immediate commit replaces one in step.
        ask(30, 30, 1, 0, 2);
        ask(31, 31, 1, 0, 0);
        period(31);
        in_step = 1;
        period(31);
        in_step = 0;
        // At a trigger: nothing else takes the command, and the trigger takes no other.
        ask(40, 41, 1, 2, 3);
        `CHECK("waiting in step for a trigger", waits_in_step, 1'b0)
        repeat (3) beginning(31, 0);
        in_step = 1;
        beginning(31, 0);
        {in_step, triggered} = 2'b01;
        beginning(40, 1);
        `CHECK("waiting for the trigger still", waiting, 1'b0)
        ask(50, 50, 1, 0, 1);
        beginning(41, 0);
        triggered = 0;
        // A cycle begins with a PLAY and with each loop of several slots; not with a frame, nor a loop of one slot.
        beginning(50, 1);
        repeat (3) beginning(50, 0);
        is_play = 0;
        ask(51, 51, 1, 0, 0);
        repeat (2) beginning(51, 0);
        is_play = 1;
        ask(60, 61, 2, 2, 0);
        repeat (2) begin
            beginning(60, 1);
            beginning(60, 0);
            repeat (2) beginning(61, 0);
        end
        repeat (3) beginning(61, 0);
        `END
    end
endmodule
