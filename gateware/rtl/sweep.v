// Once per period, over all channels, a channel per clock: calibration, silencer, modulation and pulse width turn the
// current frame into pulses for the lanes.
`include "packets.vh"
`default_nettype none

module sweep #(
    parameter CHANNEL_BITS = 8,
    parameter PHASE_BITS = 7,
    parameter [15:0] MUTE_STEP = `MUTE_STEP
) (
    input  wire                    clk,
    input  wire                    reset,
    input  wire                    restart,         // RESET, while no sweep runs
    input  wire                    start,
    input  wire                    enabled,
    output wire [CHANNEL_BITS-1:0] channel,         // of the frame to be read
    input  wire [7:0]              phase,           // a clock later
    input  wire [7:0]              amplitude,
    input  wire [7:0]              envelope,
    input  wire                    set_steps,
    input  wire [15:0]             set_phase_step,
    input  wire [15:0]             set_amplitude_step,
    input  wire                    write_offset,
    input  wire                    write_gain,
    input  wire                    write_width,
    input  wire [7:0]              write_address,
    input  wire [7:0]              offset_written,
    input  wire [7:0]              gain_written,
    input  wire [7:0]              width_written,
    input  wire                    digesting,       // read the tables at `digest_address`
    input  wire [7:0]              digest_address,
    output wire [7:0]              offset,
    output wire [7:0]              gain,
    output wire [7:0]              width_read,
    output reg                     pulse_write,
    output reg  [CHANNEL_BITS-1:0] pulse_channel,
    output reg  [PHASE_BITS-1:0]   pulse_rise,
    output reg  [PHASE_BITS-1:0]   pulse_width,
    output reg                     sounds           // something is to be heard in the next period
);
    // `step` counts clocks. Channel n leaves the silencer at n + 5 and its width is known at n + 7; before channel 0
    // and after the last, the highest bit of the difference is set. This requires at least eight channels.
    localparam [CHANNEL_BITS:0] CHANNELS = 1 << CHANNEL_BITS;
    localparam [CHANNEL_BITS:0] SILENCED = 5;
    localparam [CHANNEL_BITS:0] PULSED = 7;
    localparam [CHANNEL_BITS:0] END = CHANNELS + PULSED;
    localparam [CHANNEL_BITS:0] ONE = 1;

    reg [CHANNEL_BITS:0]  step;
    wire [CHANNEL_BITS:0] silenced = step - SILENCED;
    wire [CHANNEL_BITS:0] pulsed = step - PULSED;
    assign channel = step[CHANNEL_BITS-1:0];

    reg [15:0] phase_step, amplitude_step;
    wire       hurry = !enabled && amplitude_step < MUTE_STEP;

    // Clock 1: the memories' outputs.
    wire [7:0]  own_place;
    wire [31:0] state;
    generate
        if (CHANNEL_BITS == 8) begin : all
            assign own_place = channel;
        end else begin : some
            assign own_place = {{8 - CHANNEL_BITS{1'b0}}, channel};
        end
    endgenerate
    wire [7:0] table_place = digesting ? digest_address : own_place;
    ram offsets (
        .clk(clk),
        .write(write_offset),
        .write_address(write_address),
        .write_data(offset_written),
        .read_address(table_place),
        .read_data(offset)
    );
    ram gains (
        .clk(clk),
        .write(write_gain),
        .write_address(write_address),
        .write_data(gain_written),
        .read_address(table_place),
        .read_data(gain)
    );

    // Clocks 2 and 3: calibrated. After RESET the silencer starts at zero, independently of its memory.
    reg        fresh;
    reg [7:0]  phase_2, phase_3, amplitude_2;
    reg [8:0]  gain_2;
    reg [7:0]  amplitude_3, below_3;
    reg [31:0] state_2, state_3;
    always @(posedge clk) begin
        phase_2 <= phase + offset;
        amplitude_2 <= amplitude;
        gain_2 <= {1'b0, gain} + 9'd1;
        state_2 <= fresh ? 32'd0 : state;
        phase_3 <= phase_2;
        {amplitude_3, below_3} <= {8'd0, amplitude_2} * {7'd0, gain_2};
        state_3 <= state_2;
    end

    // Clock 5: silenced.
    wire [15:0] phase_5, amplitude_5;
    wire        silenced_now = !silenced[CHANNEL_BITS];
    silencer silencer (
        .clk(clk),
        .phase_step(phase_step),
        .amplitude_step(hurry ? MUTE_STEP : amplitude_step),
        .phase_target(phase_3),
        .amplitude_target(enabled ? amplitude_3 : 8'd0),
        .phase(state_3[15:0]),
        .amplitude(state_3[31:16]),
        .phase_next(phase_5),
        .amplitude_next(amplitude_5)
    );
    ram #(.ADDRESS_BITS(CHANNEL_BITS), .WIDTH(32)) states (
        .clk(clk),
        .write(silenced_now),
        .write_address(silenced[CHANNEL_BITS-1:0]),
        .write_data({amplitude_5, phase_5}),
        .read_address(channel),
        .read_data(state)
    );

    // Clocks 6 and 7: modulated, and its width looked up. Zero amplitude has zero width, independently of the table.
    reg [7:0]  phase_6, phase_7;
    reg [7:0]  amplitude_6, below_6;
    reg [8:0]  envelope_held;
    reg        silent_7;
    always @(posedge clk) begin
        phase_6 <= phase_5[15:8];
        {amplitude_6, below_6} <= {8'd0, amplitude_5[15:8]} * {7'd0, envelope_held};
        envelope_held <= {1'b0, envelope} + 9'd1;
        phase_7 <= phase_6;
        silent_7 <= amplitude_6 == 8'd0;
    end
    ram widths (
        .clk(clk),
        .write(write_width),
        .write_address(write_address),
        .write_data(width_written),
        .read_address(digesting ? digest_address : amplitude_6),
        .read_data(width_read)
    );

    // Clock 8: a pulse.
    wire [PHASE_BITS-1:0] rise, width;
    pulse #(.PHASE_BITS(PHASE_BITS)) pulse (
        .middle(phase_7), .width_256(silent_7 ? 8'd0 : width_read), .rise(rise), .width(width)
    );
    always @(posedge clk) begin
        pulse_write <= !pulsed[CHANNEL_BITS];
        pulse_channel <= pulsed[CHANNEL_BITS-1:0];
        pulse_rise <= rise;
        pulse_width <= width;
        if (reset) pulse_write <= 1'b0;
    end

    wire unused = &{1'b0, below_3, below_6};    // rounded off

    reg heard;
    always @(posedge clk) begin
        if (start) step <= {CHANNEL_BITS + 1{1'b0}};
        else if (step != END) step <= step + ONE;

        if (start) heard <= enabled;
        else if (silenced_now && amplitude_5 != 16'd0) heard <= 1'b1;

        if (step == END - ONE) begin
            sounds <= heard;
            fresh <= 1'b0;
        end
        if (set_steps) begin
            phase_step <= set_phase_step;
            amplitude_step <= set_amplitude_step;
        end

        if (reset) begin
            step <= END;
            heard <= 1'b0;
            sounds <= 1'b0;
        end
        if (reset || restart) begin
            fresh <= 1'b1;
            phase_step <= `FIRST_PHASE_STEP;
            amplitude_step <= `FIRST_AMPLITUDE_STEP;
        end
    end
endmodule

`default_nettype wire
