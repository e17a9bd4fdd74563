// The device: bytes come in, 256 pulse trains go out through 32 shift registers. One clock of 8 * 2^max(PHASE_BITS,
// 7) per period of the carrier. doc/protocol.md defines its behaviour.
`include "packets.vh"
`default_nettype none

module device #(
    parameter PHASE_BITS = 7,                           // 5 to 8
    parameter SLOT_BITS = 6,                            // up to 8
    parameter [31:0] CARRIER_MHZ = 32'd40000000,        // millihertz, clock / clocks per period
    parameter [15:0] FIRST_INCREMENT = PHASE_BITS == 8 ? 16'd1600 : 16'd3200, // 65536 * 2 000 000 / clock
    parameter [7:0] LARGEST_BAUD = 8'd80,                // in 100 000 baud; a bit needs five clocks
    parameter SYNC_LATENCY = 2                           // 2, and a clock for each register between `sync` and `sync_in`
) (
    input  wire        clk,
    input  wire        reset,
    input  wire        rxd,
    output wire        txd,
    // Deliberately used both synchronously and asynchronously.
    /* verilator lint_off SYNCASYNCNET */
    input  wire        estop_n,     // low: emergency stop; pull it down, so that an open wire stops
    /* verilator lint_on SYNCASYNCNET */
    input  wire        sync_in,     // another device's `sync`, to follow it; pull it down
    input  wire        trigger_in,  // rising: a waiting PLAY begins; pull it down
    input  wire [2:0]  address,     // on a line with others; pull it down
    output wire [31:0] data,        // one bit for each shift register
    output wire        shift,       // the registers take it in the middle of this clock
    output wire        latch,       // rising: the shifted bits go to the outputs
    output wire        oe_n,
    output wire        sync,        // rising: level 0 of a period goes to the outputs; for followers
    output wire        trigger,     // high for the first period of a cycle
    output wire        led_on,
    output wire        led_tripped,
    output wire        led_packet   // turns over with every good packet
);
    localparam PERIOD_BITS = PHASE_BITS == 8 ? 11 : 10;

    wire rxd_here, sync_in_here, trigger_in_here;
    synchroniser synchronise_rxd (.clk(clk), .reset(reset), .from_outside(rxd), .synchronised(rxd_here));
    synchroniser #(.AFTER_RESET(1'b0)) synchronise_sync (
        .clk(clk), .reset(reset), .from_outside(sync_in), .synchronised(sync_in_here)
    );
    synchroniser #(.AFTER_RESET(1'b0)) synchronise_trigger (
        .clk(clk), .reset(reset), .from_outside(trigger_in), .synchronised(trigger_in_here)
    );
    reg [2:0] own_address, own_address_before;
    always @(posedge clk) {own_address, own_address_before} <= {own_address_before, address};

    // Time.
    reg  mark;      // this period is in step, by our own decision
    wire on;        // the outputs, if the emergency stop does not forbid it
    wire enabled, sounds, hold, skip, skips, follows, marked, play_in_step;
    wire last, count, boundary, sweep_starts, gate_opens, lanes_period_ends, bank;
    wire [PERIOD_BITS-1:0] tick, ahead;
    ticks #(.PERIOD_BITS(PERIOD_BITS), .PHASE_BITS(PHASE_BITS)) ticks (
        .clk(clk), .reset(reset), .hold(hold), .skip(skip), .skips(skips), .tick(tick),
        .last(last), .count(count), .boundary(boundary), .sweep(sweep_starts), .gate(gate_opens),
        .period_ends(lanes_period_ends), .ahead(ahead), .bank(bank)
    );
    follower #(.PERIOD_BITS(PERIOD_BITS), .PHASE_BITS(PHASE_BITS), .LATENCY(SYNC_LATENCY)) follower (
        .clk(clk), .reset(reset), .sync_in(sync_in_here), .tick(tick), .still(!enabled && !on && !sounds),
        .period_ends(lanes_period_ends), .boundary(boundary),
        .follows(follows), .marked(marked), .hold(hold), .skip(skip), .skipped(skips)
    );

    // After a reset, store and tables are restored before any packet is accepted.
    wire                 waking, restore_starts, restored, restore_write;
    wire [SLOT_BITS+7:0] restore_place;
    wire [7:0]           restore_width;
    wire                 asleep = reset || waking;
    restore #(.SLOT_BITS(SLOT_BITS)) restore (
        .clk(clk), .reset(reset), .start(restore_starts), .open(gate_opens),
        .waking(waking), .restored(restored),
        .write(restore_write), .place(restore_place), .width(restore_width)
    );

    wire caught, stopped, pressed, let_go;
    wire emergency_now = stopped || pressed;
    emergency emergency (
        .clk(clk), .reset(reset), .estop_n(estop_n), .let_go(let_go || waking),
        .caught(caught), .stopped(stopped), .pressed(pressed)
    );

    // The line.
    wire        forgotten, baud, at_work, answers_idle;
    wire [15:0] increment;
    wire [31:0] arguments;
    line_rate #(.FIRST_INCREMENT(FIRST_INCREMENT)) line_rate (
        .clk(clk), .reset(asleep),
        .ask(baud), .asked(arguments[15:0]),
        .answered(!at_work && answers_idle),
        .fall_back(forgotten),
        .increment(increment)
    );

    wire       received, framing;
    wire [7:0] received_byte;
    uart_rx uart_rx (
        .clk(clk), .reset(asleep), .increment(increment), .rxd(rxd_here),
        .valid(received), .data(received_byte), .framing(framing)
    );

    wire       packet_ready, packet_done, broadcast, good, spoiled, spoiled_by_line, old_info;
    wire [7:0] packet_type, packet_seq, old_seq, read_data;
    wire [9:0] length;
    wire [8:0] read_address;
    receiver receiver (
        .clk(clk), .reset(asleep),
        .valid(received), .data(received_byte), .framing(framing), .address(own_address),
        .ready(packet_ready), .broadcast(broadcast), .packet_type(packet_type), .packet_seq(packet_seq), .arguments(arguments), .length(length),
        .read_address(read_address), .read_data(read_data), .done(packet_done),
        .good(good), .spoiled(spoiled), .spoiled_by_line(spoiled_by_line), .old_info(old_info), .old_seq(old_seq)
    );

    // The gate.
    wire                 slot_busy, passed, answer, answered;
    wire [7:0]           result;
    wire                 enable, mute, stop, rate, set_steps, play, play_begins, restart, digest_starts, digest_ready;
    wire [1:0]           play_when;
    wire [SLOT_BITS-1:0] play_first, play_last;
    wire [15:0]          play_divider, play_loops;
    wire                 write_phase, write_amplitude, write_envelope, write_width, write_offset, write_gain;
    wire [7:0]           write_address, write_data, amplitude_written;
    gate #(.SLOT_BITS(SLOT_BITS)) gate (
        .clk(clk), .reset(asleep), .open(gate_opens),
        .ready(packet_ready), .broadcast(broadcast), .packet_type(packet_type), .arguments(arguments), .length(length),
        .read_address(read_address), .read_data(read_data), .done(packet_done),
        .pressed(pressed), .sounding(enabled || on || sounds), .slot_busy(slot_busy), .at_work(at_work), .passed(passed),
        .result(result), .answer(answer), .answered(answered),
        .let_go(let_go), .enable(enable), .mute(mute), .baud(baud), .stop(stop), .rate(rate), .silencer(set_steps),
        .play(play), .play_first(play_first), .play_last(play_last),
        .play_divider(play_divider), .play_loops(play_loops), .play_when(play_when), .play_begins(play_begins),
        .restart(restart), .restore(restore_starts), .restored(restored), .digest(digest_starts), .digested(digest_ready),
        .write_phase(write_phase), .write_amplitude(write_amplitude), .write_envelope(write_envelope),
        .write_width(write_width), .write_offset(write_offset), .write_gain(write_gain),
        .write_address(write_address), .write_data(write_data), .amplitude_written(amplitude_written)
    );

    // Answers.
    wire        tripped, several, play_waits;
    wire        count_spoiled, count_spoiled_by_line, about_spoiled, about_old;
    wire [4:0]  index;
    wire [7:0]  value, flags;
    wire [31:0] digest_crc;
    wire [SLOT_BITS-1:0] slot;
    assign flags[`FLAG_ENABLED]   = enabled;
    assign flags[`FLAG_TRIPPED]   = tripped;
    assign flags[`FLAG_PLAYING]   = several;
    assign flags[`FLAG_EMERGENCY] = pressed;
    assign flags[`FLAG_SOUNDING]  = on && !emergency_now;
    assign flags[`FLAG_WAITING]   = play_waits;
    assign flags[`FLAG_STOPPED]   = emergency_now;
    assign flags[`FLAG_FOLLOWS]   = follows;
    status #(
        .PHASE_BITS(PHASE_BITS), .SLOT_BITS(SLOT_BITS), .CARRIER_MHZ(CARRIER_MHZ), .LARGEST_BAUD(LARGEST_BAUD)
    ) status (
        .clk(clk), .reset(asleep), .count(count),
        .good(passed), .spoiled(count_spoiled), .spoiled_by_line(count_spoiled_by_line),
        .address(own_address), .flags(flags), .slot(slot),
        .about_spoiled(about_spoiled), .about_old(about_old), .old_seq(old_seq),
        .packet_type(packet_type), .packet_seq(packet_seq), .result(result), .digest(digest_crc),
        .index(index), .value(value)
    );

    wire       send, line_ready;
    wire [7:0] sent;
    answers answers (
        .clk(clk), .reset(asleep),
        .ask(answer), .answered(answered), .silent(own_address != 3'd0),
        .spoiled(spoiled), .spoiled_by_line(spoiled_by_line), .old_info(old_info),
        .count_spoiled(count_spoiled), .count_spoiled_by_line(count_spoiled_by_line),
        .about_spoiled(about_spoiled), .about_old(about_old), .index(index), .value(value),
        .send(send), .sent(sent), .line_ready(line_ready), .idle(answers_idle)
    );
    uart_tx uart_tx (
        .clk(clk), .reset(asleep), .increment(increment), .valid(send), .data(sent), .ready(line_ready), .txd(txd)
    );

    // Playback.
    safety safety (
        .clk(clk), .reset(asleep), .restart(restart), .count(count), .boundary(boundary), .emergency(emergency_now),
        .good_packet(passed), .enable(enable), .enable_watchdog(arguments[15:0]), .mute(mute),
        .enabled(enabled), .tripped(tripped), .forgotten(forgotten)
    );
    wire triggered, player_begins, modulation_begins;
    player #(.SLOT_BITS(SLOT_BITS)) player (
        .clk(clk), .reset(asleep || restart), .boundary(boundary), .in_step(mark || (follows && marked)), .triggered(triggered),
        .play(play), .play_first(play_first), .play_last(play_last),
        .play_divider(play_divider), .play_loops(play_loops), .play_when(play_when), .play_begins(play_begins), .stop(stop),
        .query(arguments[SLOT_BITS-1:0]), .busy(slot_busy),
        .slot(slot), .several(several), .waiting(play_waits), .waits_in_step(play_in_step),
        .begins(player_begins)
    );
    trigger trigger_pins (
        .clk(clk), .reset(reset), .trigger_in(trigger_in_here), .boundary(boundary), .decide(sweep_starts),
        .player_begins(player_begins), .several(several), .modulation_begins(modulation_begins), .last(last), .sounds(sounds),
        .triggered(triggered), .trigger(trigger)
    );

    // The memories behind it: written by the gate and by restore, read by sweeps and digests.
    wire       digesting;
    wire [7:0] digest_address;
    wire [7:0] place = restore_write ? restore_place[7:0] : write_address;
    wire [7:0] zero_or_written = restore_write ? 8'd0 : write_data;
    wire [7:0] full_or_written = restore_write ? 8'd255 : write_data;
    wire [7:0] envelope, channel, phase, amplitude;
    modulation modulation (
        .clk(clk), .reset(asleep || restart), .boundary(boundary),
        .set(rate), .set_step(arguments[23:0]), .set_start(arguments[24]),
        .write(write_envelope || restore_write), .write_address(place), .write_data(full_or_written),
        .digesting(digesting), .digest_address(digest_address), .envelope(envelope), .begins(modulation_begins)
    );
    frames #(.SLOT_BITS(SLOT_BITS)) frames (
        .clk(clk),
        .write_phase(write_phase || restore_write), .write_amplitude(write_amplitude || restore_write),
        .write_address({restore_write ? restore_place[SLOT_BITS+7:8] : arguments[SLOT_BITS-1:0], place}),
        .phase_written(zero_or_written), .amplitude_written(restore_write ? 8'd0 : amplitude_written),
        .read_address(digesting ? {arguments[8+SLOT_BITS-1:8], digest_address} : {slot, channel}),
        .phase(phase), .amplitude(amplitude)
    );

    // From there to pulses.
    wire                  pulse_write;
    wire [7:0]            offset, gain, width_read, pulse_channel;
    wire [PHASE_BITS-1:0] pulse_rise, pulse_width;
    sweep #(.PHASE_BITS(PHASE_BITS)) sweep (
        .clk(clk), .reset(reset), .restart(waking || restart), .start(sweep_starts), .enabled(enabled),
        .channel(channel), .phase(phase), .amplitude(amplitude), .envelope(envelope),
        .set_steps(set_steps), .set_phase_step(arguments[15:0]), .set_amplitude_step(arguments[31:16]),
        .write_offset(write_offset || restore_write), .write_gain(write_gain || restore_write),
        .write_width(write_width || restore_write), .write_address(place),
        .offset_written(zero_or_written), .gain_written(full_or_written),
        .width_written(restore_write ? restore_width : write_data),
        .digesting(digesting), .digest_address(digest_address), .offset(offset), .gain(gain), .width_read(width_read),
        .pulse_write(pulse_write), .pulse_channel(pulse_channel), .pulse_rise(pulse_rise), .pulse_width(pulse_width),
        .sounds(sounds)
    );
    digest digest (
        .clk(clk), .reset(asleep), .start(digest_starts), .what(arguments[1:0]),
        .reading(digesting), .address(digest_address),
        .phase(phase), .amplitude(amplitude), .envelope(envelope), .width(width_read), .offset(offset), .gain(gain),
        .crc(digest_crc), .ready(digest_ready)
    );
    lanes #(.PERIOD_BITS(PERIOD_BITS), .PHASE_BITS(PHASE_BITS)) lanes (
        .clk(clk), .reset(reset), .ahead(ahead), .hold(hold), .bank(bank), .mark(mark),
        .write(pulse_write), .write_channel(pulse_channel), .write_rise(pulse_rise), .write_width(pulse_width),
        .data(data), .shift(shift), .latch(latch), .sync(sync)
    );

    outputs outputs (
        .clk(clk), .reset(reset), .last(last), .sounds(sounds), .caught(caught), .estop_n(estop_n), .on(on), .oe_n(oe_n)
    );

    reg packet_parity;
    always @(posedge clk) begin
        if (last) mark <= play_in_step && !follows;
        if (good) packet_parity <= !packet_parity;
        if (reset) begin
            mark <= 1'b0;
            packet_parity <= 1'b0;
        end
    end
    assign led_on = on;
    assign led_tripped = tripped;
    assign led_packet = packet_parity;
endmodule

`default_nettype wire
