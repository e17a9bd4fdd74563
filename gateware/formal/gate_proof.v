// gate with any packet at any time: preconditions of each effect. Deep enough to write a memory's first cells and to
// complete short packets.
`include "packets.vh"
`default_nettype none
module gate_proof (
    input wire        clk,
    input wire        open,
    input wire        pressed,
    input wire        sounding,
    input wire        broadcast,
    input wire        restored,
    input wire        digested,
    input wire        slot_busy,
    input wire        answered,
    input wire [7:0]  read_data,
    input wire        ready,
    input wire [7:0]  any_type,
    input wire [31:0] any_arguments,
    input wire [9:0]  any_length
);
    reg reset = 1'b1;
    always @(posedge clk) reset <= 1'b0;

    // The front packet is stable while processed.
    reg [49:0] packet;
    wire       at_work, done, passed, answer;
    always @(posedge clk) if (!at_work) packet <= {any_type, any_arguments, any_length};
    wire [7:0]  packet_type = packet[49:42];
    wire [31:0] arguments = packet[41:10];
    wire [9:0]  length = packet[9:0];

    reg        for_all;
    always @(posedge clk) if (!at_work) for_all <= broadcast;
    wire       enable, mute, baud, stop, rate, silencer, play, restart, let_go, restore, digest;
    wire [1:0] play_when;
    wire [5:0] play_first, play_last;
    wire [15:0] play_divider;
    wire [7:0] result;
    wire       write_phase, write_amplitude, write_envelope, write_width, write_offset, write_gain;
    gate gate (
        .clk(clk), .reset(reset), .open(open), .ready(ready), .broadcast(for_all), .packet_type(packet_type), .arguments(arguments), .length(length),
        .read_data(read_data), .done(done), .pressed(pressed), .sounding(sounding), .restored(restored), .digested(digested),
        .restore(restore), .digest(digest), .restart(restart), .let_go(let_go), .slot_busy(slot_busy),
        .at_work(at_work), .passed(passed), .result(result), .answer(answer), .answered(answered),
        .enable(enable), .mute(mute), .baud(baud), .stop(stop), .rate(rate), .silencer(silencer), .play(play),
        .play_first(play_first), .play_last(play_last), .play_divider(play_divider), .play_when(play_when),
        .write_phase(write_phase), .write_amplitude(write_amplitude), .write_envelope(write_envelope),
        .write_width(write_width), .write_offset(write_offset), .write_gain(write_gain)
    );

    wire tells = restart || enable || mute || baud || stop || rate || silencer || play;
    wire writes = write_phase || write_amplitude || write_envelope || write_width || write_offset || write_gain;
    wire to_slot = packet_type == `TYPE_PHASES || packet_type == `TYPE_FRAME;
    reg  checked;       // and found good, since the gate was opened
    reg [2:0] let;      // clocks since it was let go of the emergency stop
    always @(posedge clk) let <= reset ? 3'd0 : let_go ? 3'd1 : let == 3'd0 || let == 3'd7 ? 3'd0 : let + 3'd1;
    always @(posedge clk) begin
        if (passed) checked <= 1'b1;
        if (reset || !at_work) checked <= 1'b0;
    end

    always @(posedge clk) if (!reset) begin
        if (tells || writes) assert (at_work && checked && result == `RESULT_OK);
        if (tells) assert ({2'b00, enable} + restart + mute + baud + stop + rate + silencer + play == 1);
        if (let_go || restore || digest) assert (at_work && (checked || passed) && !tells);
        if (write_phase || write_amplitude) assert (to_slot && arguments[7:6] == 2'd0);
        if (enable) assert (packet_type == `TYPE_ENABLE && (arguments[15:0] != 0 || arguments[23:16] == `CONFIRM));
        // The release is known by then, and every release is followed by an enable or a restart.
        if (enable || restart) assert (let == 3'd4);
        if (let == 3'd4) assert (enable || restart);
        if (restart) assert (packet_type == `TYPE_RESET && length == 10'd0);
        if (answer) assert (!for_all);
        if ($past(passed) && $past(sounding)) assert (packet_type != `TYPE_RESET || result != `RESULT_OK);
        if (baud) assert (arguments[15:0] >= 64 && arguments[15:0] <= 16384);
        if (play) assert (play_first <= play_last && play_divider != 16'd0 && play_when <= `WHEN_AT_TRIGGER);
        if (play && to_slot) assert (play_first == play_last && play_when != `WHEN_AFTER_LOOP && play_when != `WHEN_AT_TRIGGER);
        if ($past(passed) && $past(pressed)) assert (packet_type != `TYPE_ENABLE || result != `RESULT_OK);
        if ($past(passed) && $past(slot_busy)) assert (!to_slot || result != `RESULT_OK);
        cover (write_phase && write_amplitude);
        cover (write_gain);
        cover (play && play_when == `WHEN_AFTER_LOOP && play_first != play_last);
        cover (restart);
        cover (done && packet_type == `TYPE_DIGEST && result == `RESULT_OK);
        cover (done && result == `RESULT_BUSY);
    end
endmodule
