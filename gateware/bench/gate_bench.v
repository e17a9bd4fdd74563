// gate: every packet's effect and no other, every refusal, and nothing while it is closed.
`include "check.vh"
`include "packets.vh"
module gate_bench;
    `include "bench.vh"
    reg         reset = 1, open = 0, ready = 0, broadcast = 0, pressed = 0, sounding = 0, slot_busy = 0, restored = 0, digested = 0;
    reg  [7:0]  packet_type = 0, read_data = 0;
    reg  [31:0] arguments = 0;
    reg  [9:0]  length = 0;
    wire [8:0]  read_address;
    wire        done, at_work, passed, answer;
    wire        enable, mute, baud, stop, rate, silencer, play, let_go, restart, restore, digest;
    wire [1:0]  play_when;
    wire        play_begins;
    wire [7:0]  result, write_address, write_data, amplitude_written;
    wire [5:0]  play_first, play_last;
    wire [15:0] play_divider, play_loops;
    wire        write_phase, write_amplitude, write_envelope, write_width, write_offset, write_gain;
    gate gate (
        .clk(clk), .reset(reset), .open(open), .ready(ready), .broadcast(broadcast), .packet_type(packet_type), .arguments(arguments), .length(length),
        .read_address(read_address), .read_data(read_data), .done(done), .pressed(pressed), .sounding(sounding), .slot_busy(slot_busy),
        .at_work(at_work), .passed(passed), .result(result), .answer(answer), .answered(answer),
        .let_go(let_go), .enable(enable), .mute(mute), .baud(baud), .stop(stop), .rate(rate), .silencer(silencer),
        .play(play), .play_first(play_first), .play_last(play_last), .play_divider(play_divider),
        .play_loops(play_loops), .play_when(play_when), .play_begins(play_begins),
        .restart(restart), .restore(restore), .restored(restored), .digest(digest), .digested(digested),
        .write_phase(write_phase), .write_amplitude(write_amplitude), .write_envelope(write_envelope),
        .write_width(write_width), .write_offset(write_offset), .write_gain(write_gain),
        .write_address(write_address), .write_data(write_data), .amplitude_written(amplitude_written)
    );

    reg [7:0] payload [0:511];
    always @(posedge clk) read_data <= payload[read_address];

    // The effects: strobes (with counts), and sums that identify the destinations of bytes.
    wire [7:0] strobes = {restart, enable, mute, baud, stop, rate, silencer, play};
    reg  [7:0] told;
    integer phases, amplitudes, envelopes, widths, offsets, gains, tellings, passes, wrong, answers, lettings, restores, digests, since_letting;
    always @(posedge clk) begin
        told = told | strobes;
        if (strobes != 0) tellings = tellings + 1;
        if (passed) passes = passes + 1;
        if (answer) answers = answers + 1;
        since_letting = let_go ? 0 : since_letting + 1;
        if (let_go) lettings = lettings + 1;
        if (restore) restores = restores + 1;
        if (digest) digests = digests + 1;
        // Effects must wait until the release of the stop is known, two clocks after it.
        if ((enable || restart) && since_letting < 3) wrong = wrong + 1;
        if ((enable || restart) && lettings != 1) wrong = wrong + 1;
        if (write_phase) begin
            phases = phases + 1;
            if (write_data !== payload[packet_type == `TYPE_FRAME ? 2 * write_address : write_address]) wrong = wrong + 1;
        end
        if (write_amplitude) begin
            amplitudes = amplitudes + 1;
            if (amplitude_written !== (packet_type == `TYPE_FRAME ? payload[2 * write_address + 1] : arguments[15:8]))
                wrong = wrong + 1;
        end
        if (write_envelope || write_width) begin
            if (write_envelope) envelopes = envelopes + 1; else widths = widths + 1;
            if (write_data !== payload[write_address]) wrong = wrong + 1;
        end
        if (write_offset || write_gain) begin
            if (write_offset) offsets = offsets + 1; else gains = gains + 1;
            if (write_data !== payload[2 * write_address + write_gain]) wrong = wrong + 1;
        end
    end

    integer clocks;
    task packet(input [7:0] kind, input [31:0] with, input [9:0] bytes, input [7:0] expected);
        begin
            {told, phases, amplitudes, envelopes, widths, offsets, gains, tellings, passes, wrong, answers, lettings, restores, digests, since_letting} = 0;
            {packet_type, arguments, length, ready} = {kind, with, bytes, 1'b1};
            repeat (5) @(negedge clk) `CHECK("work while closed", at_work, 1'b0)
            open = 1;
            @(negedge clk) open = 0;
            clocks = 1;
            while (!done) begin
                @(negedge clk);
                clocks = clocks + 1;
                restored = clocks == 500;
                digested = clocks == 530;
            end
            {restored, digested} = 0;
            `CHECK("the result", result, expected)
            `CHECK("let go", lettings, told[7] + told[6])
            `CHECK("restored", restores, told[7])
            `CHECK("digested", digests, kind == `TYPE_DIGEST && expected == `RESULT_OK)
            `CHECK("the passes", passes, 1)
            `CHECK("what was written wrong", wrong, 0)
            `CHECK("more clocks than a period leaves", clocks > 640, 1'b0)
            @(negedge clk) ready = 0;
            `CHECK("an answer", answers != 0, !broadcast)
            repeat (5) @(negedge clk) `CHECK("work without a packet", at_work, 1'b0)
        end
    endtask
    task wrote(input integer p, input integer a, input integer e, input integer w, input integer o, input integer g);
        `CHECK("what was written", {p, a, e, w, o, g}, {phases, amplitudes, envelopes, widths, offsets, gains})
    endtask
    task good(input [7:0] kind, input [31:0] with, input [9:0] bytes, input [7:0] telling);
        begin
            packet(kind, with, bytes, `RESULT_OK);
            `CHECK("who was told", told, telling)
            `CHECK("how often", tellings, telling != 0)
        end
    endtask
    // A refused packet has no effect.
    task refused(input [7:0] kind, input [31:0] with, input [9:0] bytes, input [7:0] why);
        begin
            packet(kind, with, bytes, why);
            `CHECK("who was told", told, 8'd0)
            wrote(0, 0, 0, 0, 0, 0);
        end
    endtask

    localparam [7:0] RESTART = 128, ENABLE = 64, MUTE = 32, BAUD = 16, STOP = 8, RATE = 4, SILENCER = 2, PLAY = 1;
    integer i;
    initial begin
        for (i = 0; i < 512; i = i + 1) payload[i] = $random;
        {payload[0], payload[1], payload[2]} = {8'h34, 8'h12, 8'd1};
        repeat (2) @(negedge clk);
        reset = 0;

        good(`TYPE_INFO, 0, 0, 0);
        good(`TYPE_STATUS, 0, 0, 0);
        good(`TYPE_ENABLE, 32'h00000001, 0, ENABLE);
        good(`TYPE_ENABLE, 32'h005A0000, 0, ENABLE);
        good(`TYPE_MUTE, 0, 0, MUTE);
        good(`TYPE_BAUD, 64, 0, BAUD);
        good(`TYPE_BAUD, 16384, 0, BAUD);
        good(`TYPE_STOP, 0, 0, STOP);
        good(`TYPE_RATE, 32'h01123456, 0, RATE);
        good(`TYPE_SILENCER, 32'hFFFF0001, 0, SILENCER);
        good(`TYPE_PLAY, 32'hABCD3F02, 3, PLAY);
        `CHECK("the play", {play_first, play_last, play_divider, play_loops, play_when, play_begins}, {6'd2, 6'd63, 16'hABCD, 16'h1234, `WHEN_AFTER_LOOP, 1'b1})
        good(`TYPE_PLAY, 32'h00013F3F, 3, PLAY);
        good(`TYPE_PHASES, 32'h0000C805, 256, 0);
        wrote(256, 256, 0, 0, 0, 0);
        good(`TYPE_PHASES, 32'h0001C805, 256, PLAY);
        `CHECK("the commit", {play_first, play_last, play_divider, play_loops, play_when, play_begins}, {6'd5, 6'd5, 16'd1, 16'd0, `WHEN_AT_ONCE, 1'b0})
        good(`TYPE_FRAME, 32'h0000003F, 512, 0);
        wrote(256, 256, 0, 0, 0, 0);
        good(`TYPE_FRAME, 32'h0001003F, 512, PLAY);
        good(`TYPE_FRAME, 32'h0003003F, 512, PLAY);
        `CHECK("the commit in step", {play_first, play_last, play_when}, {6'd63, 6'd63, `WHEN_IN_STEP})
        good(`TYPE_FRAME, 32'h0002003F, 512, 0);
        good(`TYPE_RESET, 0, 0, RESTART);
        good(`TYPE_DIGEST, 32'h00003F00, 0, 0);
        good(`TYPE_DIGEST, 32'h00004003, 0, 0);
        broadcast = 1;
        good(`TYPE_MUTE, 0, 0, MUTE);
        good(`TYPE_ENABLE, 7, 0, ENABLE);
        good(`TYPE_DIGEST, 0, 0, 0);
        refused(8'h12, 0, 0, `RESULT_UNKNOWN);
        broadcast = 0;
        good(`TYPE_ENVELOPE, 0, 256, 0);
        wrote(0, 0, 256, 0, 0, 0);
        good(`TYPE_WIDTHS, 0, 256, 0);
        wrote(0, 0, 0, 256, 0, 0);
        good(`TYPE_CALIBRATION, 0, 512, 0);
        wrote(0, 0, 0, 0, 256, 256);

        refused(8'h00, 0, 0, `RESULT_UNKNOWN);
        refused(8'h12, 0, 512, `RESULT_UNKNOWN);
        refused(8'h83, 1, 0, `RESULT_UNKNOWN);
        refused(`TYPE_INFO, 0, 1, `RESULT_LENGTH);
        refused(`TYPE_FRAME, 1, 511, `RESULT_LENGTH);
        refused(`TYPE_PHASES, 1, 512, `RESULT_LENGTH);
        refused(`TYPE_PLAY, 32'h00010101, 2, `RESULT_LENGTH);
        refused(`TYPE_ENABLE, 0, 0, `RESULT_ARGUMENT);
        refused(`TYPE_ENABLE, 32'h005B0000, 0, `RESULT_ARGUMENT);
        refused(`TYPE_BAUD, 63, 0, `RESULT_ARGUMENT);
        refused(`TYPE_BAUD, 16385, 0, `RESULT_ARGUMENT);
        refused(`TYPE_SILENCER, 32'h00000300, 0, `RESULT_ARGUMENT);
        refused(`TYPE_SILENCER, 32'h03000000, 0, `RESULT_ARGUMENT);
        refused(`TYPE_PHASES, 64, 256, `RESULT_ARGUMENT);
        refused(`TYPE_FRAME, 32'h00010080, 512, `RESULT_ARGUMENT);
        refused(`TYPE_PLAY, 32'h00014001, 3, `RESULT_ARGUMENT);
        refused(`TYPE_PLAY, 32'h00010102, 3, `RESULT_ARGUMENT);
        refused(`TYPE_PLAY, 32'h00000201, 3, `RESULT_ARGUMENT);
        refused(`TYPE_DIGEST, 32'h00004000, 0, `RESULT_ARGUMENT);
        refused(`TYPE_DIGEST, 32'h00000004, 0, `RESULT_ARGUMENT);
        refused(`TYPE_RESET, 0, 3, `RESULT_LENGTH);
        payload[2] = 2;
        good(`TYPE_PLAY, 32'h00010201, 3, PLAY);
        `CHECK("a play in step", play_when, `WHEN_IN_STEP)
        payload[2] = 3;
        good(`TYPE_PLAY, 32'h00010201, 3, PLAY);
        `CHECK("a play at a trigger", play_when, `WHEN_AT_TRIGGER)
        payload[2] = 4;
        refused(`TYPE_PLAY, 32'h00010201, 3, `RESULT_ARGUMENT);
        slot_busy = 1;
        refused(`TYPE_PHASES, 32'h00010001, 256, `RESULT_BUSY);
        refused(`TYPE_FRAME, 32'h00000001, 512, `RESULT_BUSY);
        good(`TYPE_WIDTHS, 0, 256, 0);
        pressed = 1;
        refused(`TYPE_ENABLE, 1, 0, `RESULT_STATE);
        good(`TYPE_RESET, 0, 0, RESTART);
        sounding = 1;
        refused(`TYPE_RESET, 0, 0, `RESULT_STATE);
        good(`TYPE_MUTE, 0, 0, MUTE);
        `END
    end
endmodule
