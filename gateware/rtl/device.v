// The device: bytes come in, 256 pulse trains go out through 32 shift registers. One clock of 8 * 2^max(PHASE_BITS, 7) per period
// of the carrier. doc/protocol.md says what it does.
`include "packets.vh"
`default_nettype none

module device #(
    parameter PHASE_BITS = 7,                           // 5 to 8
    parameter SLOT_BITS = 6,                            // up to 8
    parameter [31:0] CARRIER_MHZ = 32'd40000000,        // millihertz, clock / clocks per period
    parameter [15:0] FIRST_INCREMENT = PHASE_BITS == 8 ? 16'd1600 : 16'd3200, // 65536 * 2 000 000 / clock
    parameter [7:0] LARGEST_BAUD = 8'd30                 // in 100 000 baud
) (
    input  wire        clk,
    input  wire        reset,
    input  wire        rxd,
    output wire        txd,
    input  wire        estop_n,     // low: emergency stop; pull it up
    output wire [31:0] data,        // one bit for each shift register
    output wire        shift,       // the registers take it in the middle of this clock
    output wire        latch,       // rising: what was shifted in goes to the outputs
    output wire        oe_n,
    output wire        sync,        // rising: level 0 of a period goes to the outputs
    output wire        led_on,
    output wire        led_tripped,
    output wire        led_packet   // turns over with every good packet
);
    localparam PERIOD_BITS = PHASE_BITS == 8 ? 11 : 10;

    wire rxd_inside, estop_n_inside;
    synchroniser synchronise_rxd (.clk(clk), .reset(reset), .from_outside(rxd), .inside(rxd_inside));
    synchroniser #(.AFTER_RESET(1'b0)) synchronise_estop (
        .clk(clk), .reset(reset), .from_outside(estop_n), .inside(estop_n_inside)
    );
    wire emergency = !estop_n_inside;

    wire last, count, boundary, sweep_starts, gate_opens, bank;
    wire [PERIOD_BITS-1:0] ahead;
    ticks #(.PERIOD_BITS(PERIOD_BITS), .PHASE_BITS(PHASE_BITS)) ticks (
        .clk(clk), .reset(reset),
        .last(last), .count(count), .boundary(boundary), .sweep(sweep_starts), .gate(gate_opens),
        .ahead(ahead), .bank(bank)
    );

    // The line.
    wire        forgotten, baud, at_work, answers_idle;
    wire [15:0] increment;
    wire [31:0] arguments;
    line_rate #(.FIRST_INCREMENT(FIRST_INCREMENT)) line_rate (
        .clk(clk), .reset(reset),
        .ask(baud), .asked(arguments[15:0]),
        .answered(!at_work && answers_idle),
        .fall_back(forgotten),
        .increment(increment)
    );

    wire       received, framing;
    wire [7:0] received_byte;
    uart_rx uart_rx (
        .clk(clk), .reset(reset), .increment(increment), .rxd(rxd_inside),
        .valid(received), .data(received_byte), .framing(framing)
    );

    wire       packet_ready, packet_done, good, spoiled, spoiled_by_line;
    wire [7:0] packet_type, packet_seq, read_data;
    wire [9:0] length;
    wire [8:0] read_address;
    receiver receiver (
        .clk(clk), .reset(reset),
        .valid(received), .data(received_byte), .framing(framing),
        .ready(packet_ready), .packet_type(packet_type), .packet_seq(packet_seq), .arguments(arguments), .length(length),
        .read_address(read_address), .read_data(read_data), .done(packet_done),
        .good(good), .spoiled(spoiled), .spoiled_by_line(spoiled_by_line)
    );

    // The gate.
    wire                 slot_busy, passed, answer, answered;
    wire [7:0]           result;
    wire                 enable, mute, stop, rate, set_steps, play, play_later;
    wire [SLOT_BITS-1:0] play_first, play_last;
    wire [15:0]          play_divider, play_loops;
    wire                 write_phase, write_amplitude, write_envelope, write_width, write_offset, write_gain;
    wire [7:0]           write_address, write_data, amplitude_written;
    gate #(.SLOT_BITS(SLOT_BITS)) gate (
        .clk(clk), .reset(reset), .open(gate_opens),
        .ready(packet_ready), .packet_type(packet_type), .arguments(arguments), .length(length),
        .read_address(read_address), .read_data(read_data), .done(packet_done),
        .emergency(emergency), .slot_busy(slot_busy), .at_work(at_work), .passed(passed),
        .result(result), .answer(answer), .answered(answered),
        .enable(enable), .mute(mute), .baud(baud), .stop(stop), .rate(rate), .silencer(set_steps),
        .play(play), .play_first(play_first), .play_last(play_last),
        .play_divider(play_divider), .play_loops(play_loops), .play_later(play_later),
        .write_phase(write_phase), .write_amplitude(write_amplitude), .write_envelope(write_envelope),
        .write_width(write_width), .write_offset(write_offset), .write_gain(write_gain),
        .write_address(write_address), .write_data(write_data), .amplitude_written(amplitude_written)
    );

    // Answers.
    reg         on;     // the outputs, if there is no emergency
    wire        enabled, tripped, several, play_waits;
    wire        count_spoiled, count_spoiled_by_line, about_spoiled;
    wire [3:0]  index;
    wire [7:0]  value;
    wire [5:0]  flags;
    wire [SLOT_BITS-1:0] slot;
    assign flags[`FLAG_ENABLED]   = enabled;
    assign flags[`FLAG_TRIPPED]   = tripped;
    assign flags[`FLAG_PLAYING]   = several;
    assign flags[`FLAG_EMERGENCY] = emergency;
    assign flags[`FLAG_SOUNDING]  = on && !emergency;
    assign flags[`FLAG_WAITING]   = play_waits;
    status #(
        .PHASE_BITS(PHASE_BITS), .SLOT_BITS(SLOT_BITS), .CARRIER_MHZ(CARRIER_MHZ), .LARGEST_BAUD(LARGEST_BAUD)
    ) status (
        .clk(clk), .reset(reset), .count(count),
        .good(passed), .spoiled(count_spoiled), .spoiled_by_line(count_spoiled_by_line),
        .flags(flags), .slot(slot), .about_spoiled(about_spoiled),
        .packet_type(packet_type), .packet_seq(packet_seq), .result(result),
        .index(index), .value(value)
    );

    wire       send, line_ready;
    wire [7:0] sent;
    answers answers (
        .clk(clk), .reset(reset),
        .ask(answer), .answered(answered), .spoiled(spoiled), .spoiled_by_line(spoiled_by_line),
        .count_spoiled(count_spoiled), .count_spoiled_by_line(count_spoiled_by_line),
        .about_spoiled(about_spoiled), .index(index), .value(value),
        .send(send), .sent(sent), .line_ready(line_ready), .idle(answers_idle)
    );
    uart_tx uart_tx (
        .clk(clk), .reset(reset), .increment(increment), .valid(send), .data(sent), .ready(line_ready), .txd(txd)
    );

    // What is played.
    safety safety (
        .clk(clk), .reset(reset), .count(count), .boundary(boundary), .emergency(emergency),
        .good_packet(passed), .enable(enable), .enable_watchdog(arguments[15:0]), .mute(mute),
        .enabled(enabled), .tripped(tripped), .forgotten(forgotten)
    );
    player #(.SLOT_BITS(SLOT_BITS)) player (
        .clk(clk), .reset(reset), .boundary(boundary),
        .play(play), .play_first(play_first), .play_last(play_last),
        .play_divider(play_divider), .play_loops(play_loops), .play_later(play_later), .stop(stop),
        .query(arguments[SLOT_BITS-1:0]), .busy(slot_busy),
        .slot(slot), .several(several), .waiting(play_waits)
    );

    wire [7:0] envelope, channel, phase, amplitude;
    modulation modulation (
        .clk(clk), .reset(reset), .boundary(boundary),
        .set(rate), .set_step(arguments[23:0]), .set_start(arguments[24]),
        .write(write_envelope), .write_address(write_address), .write_data(write_data),
        .envelope(envelope)
    );
    frames #(.SLOT_BITS(SLOT_BITS)) frames (
        .clk(clk),
        .write_phase(write_phase), .write_amplitude(write_amplitude),
        .write_address({arguments[SLOT_BITS-1:0], write_address}),
        .phase_written(write_data), .amplitude_written(amplitude_written),
        .read_address({slot, channel}), .phase(phase), .amplitude(amplitude)
    );

    // From that to pulses.
    wire                  pulse_write, sounds;
    wire [7:0]            pulse_channel;
    wire [PHASE_BITS-1:0] pulse_rise, pulse_width;
    sweep #(.PHASE_BITS(PHASE_BITS)) sweep (
        .clk(clk), .reset(reset), .start(sweep_starts), .enabled(enabled),
        .channel(channel), .phase(phase), .amplitude(amplitude), .envelope(envelope),
        .set_steps(set_steps), .set_phase_step(arguments[15:0]), .set_amplitude_step(arguments[31:16]),
        .write_offset(write_offset), .write_gain(write_gain), .write_width(write_width),
        .write_address(write_address), .write_data(write_data),
        .pulse_write(pulse_write), .pulse_channel(pulse_channel), .pulse_rise(pulse_rise), .pulse_width(pulse_width),
        .sounds(sounds)
    );
    lanes #(.PERIOD_BITS(PERIOD_BITS), .PHASE_BITS(PHASE_BITS)) lanes (
        .clk(clk), .reset(reset), .ahead(ahead), .bank(bank),
        .write(pulse_write), .write_channel(pulse_channel), .write_rise(pulse_rise), .write_width(pulse_width),
        .data(data), .shift(shift), .latch(latch), .sync(sync)
    );

    // The emergency stop needs no clock.
    assign oe_n = !on || !estop_n;

    reg packet_parity;
    always @(posedge clk) begin
        if (last) on <= sounds;
        if (good) packet_parity <= !packet_parity;
        if (reset) begin
            on <= 1'b0;
            packet_parity <= 1'b0;
        end
    end
    assign led_on = on;
    assign led_tripped = tripped;
    assign led_packet = packet_parity;
endmodule

`default_nettype wire
