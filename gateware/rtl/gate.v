// Lets at most one packet per period take effect, between the end of the sweep and the next boundary: checks it, then
// writes its payload into the memories, or signals the responsible module, and requests the answer.
`include "packets.vh"
`default_nettype none

module gate #(
    parameter SLOT_BITS = 6
) (
    input  wire                 clk,
    input  wire                 reset,
    input  wire                 open,           // for one clock per period

    input  wire                 ready,          // a packet waits
    input  wire                 broadcast,      // it is not answered
    input  wire [7:0]           packet_type,
    input  wire [31:0]          arguments,
    input  wire [9:0]           length,
    output wire [8:0]           read_address,   // in its payload
    input  wire [7:0]           read_data,      // a clock later
    output wire                 done,           // with the packet

    input  wire                 pressed,        // the emergency stop
    input  wire                 sounding,       // something is to be heard, or would be without the emergency stop
    input  wire                 slot_busy,      // the slot of the first argument
    output wire                 at_work,
    output wire                 passed,         // for one clock: a packet counts
    output reg  [7:0]           result,
    output wire                 answer,         // until `answered`
    input  wire                 answered,

    // Signals for one clock, with the arguments.
    output wire                 let_go,         // of the emergency stop
    output wire                 enable,
    output wire                 mute,
    output wire                 baud,
    output wire                 stop,
    output wire                 rate,
    output wire                 silencer,
    output wire                 play,
    output wire [SLOT_BITS-1:0] play_first,
    output wire [SLOT_BITS-1:0] play_last,
    output wire [15:0]          play_divider,
    output wire [15:0]          play_loops,
    output wire [1:0]           play_when,
    output wire                 play_begins,    // a PLAY, not the commit of a frame
    output wire                 restart,        // all is as after power-up

    // Operations that take longer.
    output wire                 restore,
    input  wire                 restored,
    output wire                 digest,
    input  wire                 digested,

    // Memories to write.
    output wire                 write_phase,
    output wire                 write_amplitude,
    output wire                 write_envelope,
    output wire                 write_width,
    output wire                 write_offset,
    output wire                 write_gain,
    output wire [7:0]           write_address,
    output wire [7:0]           write_data,
    output wire [7:0]           amplitude_written
);
    localparam [3:0] IDLE = 0, FETCH = 1, CHECK = 2, COPY = 3, RESTORE = 4, LET_GO = 5, COMMIT = 6, DIGEST = 7, ANSWER = 8;
    reg [3:0]  state;
    reg [9:0]  index;       // of the requested byte; `read_data` is the previous one
    reg [15:0] loops;
    reg [7:0]  when_asked;

    // Decoding of the packet.
    wire is_enable   = packet_type == `TYPE_ENABLE;
    wire is_baud     = packet_type == `TYPE_BAUD;
    wire is_reset    = packet_type == `TYPE_RESET;
    wire is_digest   = packet_type == `TYPE_DIGEST;
    wire is_phases   = packet_type == `TYPE_PHASES;
    wire is_frame    = packet_type == `TYPE_FRAME;
    wire is_play     = packet_type == `TYPE_PLAY;
    wire is_silencer = packet_type == `TYPE_SILENCER;
    wire pairs       = is_frame || packet_type == `TYPE_CALIBRATION;

    reg        known;
    reg [9:0]  right_length;
    always @* begin
        known = 1'b1;
        case (packet_type)
            `TYPE_INFO:        right_length = `PAYLOAD_INFO;
            `TYPE_STATUS:      right_length = `PAYLOAD_STATUS;
            `TYPE_ENABLE:      right_length = `PAYLOAD_ENABLE;
            `TYPE_MUTE:        right_length = `PAYLOAD_MUTE;
            `TYPE_BAUD:        right_length = `PAYLOAD_BAUD;
            `TYPE_RESET:       right_length = `PAYLOAD_RESET;
            `TYPE_DIGEST:      right_length = `PAYLOAD_DIGEST;
            `TYPE_PHASES:      right_length = `PAYLOAD_PHASES;
            `TYPE_FRAME:       right_length = `PAYLOAD_FRAME;
            `TYPE_PLAY:        right_length = `PAYLOAD_PLAY;
            `TYPE_STOP:        right_length = `PAYLOAD_STOP;
            `TYPE_ENVELOPE:    right_length = `PAYLOAD_ENVELOPE;
            `TYPE_RATE:        right_length = `PAYLOAD_RATE;
            `TYPE_SILENCER:    right_length = `PAYLOAD_SILENCER;
            `TYPE_WIDTHS:      right_length = `PAYLOAD_WIDTHS;
            `TYPE_CALIBRATION: right_length = `PAYLOAD_CALIBRATION;
            default: begin
                known = 1'b0;
                right_length = 10'd0;
            end
        endcase
    end

    // Refusals.
    wire [7:0]  a0 = arguments[7:0];
    wire [7:0]  a1 = arguments[15:8];
    wire [15:0] low = arguments[15:0];
    wire [15:0] high = arguments[31:16];
    wire no_slot_0 = {1'b0, a0} >> SLOT_BITS != 9'd0;
    wire no_slot_1 = {1'b0, a1} >> SLOT_BITS != 9'd0;
    wire wrong_argument = (is_enable && low == 16'd0 && arguments[23:16] != `CONFIRM)
        || (is_baud && (low < `SLOWEST_INCREMENT || low > `FASTEST_INCREMENT))
        || (is_digest && (a0 > 8'd3 || (a0 == 8'd0 && no_slot_1)))
        || ((is_phases || is_frame) && no_slot_0)
        || (is_play && (no_slot_0 || no_slot_1 || a1 < a0 || high == 16'd0 || when_asked > {6'd0, `WHEN_AT_TRIGGER}))
        || (is_silencer && (low == 16'd0 || high == 16'd0));
    wire [7:0] verdict = !known ? `RESULT_UNKNOWN
        : length != right_length ? `RESULT_LENGTH
        : wrong_argument ? `RESULT_ARGUMENT
        : (is_enable && pressed) || (is_reset && sounding) ? `RESULT_STATE
        : (is_phases || is_frame) && slot_busy ? `RESULT_BUSY
        : `RESULT_OK;
    wire carries = length != 10'd0 && !is_play;

    always @(posedge clk) begin
        index <= index + 10'd1;
        case (state)
            IDLE: begin
                index <= 10'd0;
                if (open && ready) state <= FETCH;
            end
            FETCH: begin
                if (index == 10'd1) loops[7:0] <= read_data;
                if (index == 10'd2) loops[15:8] <= read_data;
                if (index == 10'd3) begin
                    when_asked <= read_data;
                    state <= CHECK;
                end
            end
            CHECK: begin
                index <= 10'd0;
                result <= verdict;
                state <= verdict != `RESULT_OK ? ANSWER
                    : is_reset ? RESTORE
                    : is_enable ? LET_GO
                    : is_digest ? DIGEST
                    : carries ? COPY : COMMIT;
            end
            COPY: if (index == length) state <= COMMIT;
            RESTORE: begin
                index <= 10'd0;
                if (restored) state <= LET_GO;
            end
            // Waits until the emergency stop is known to be released, so that it does not trip at once.
            LET_GO: if (index == 10'd3) state <= COMMIT;
            COMMIT: state <= ANSWER;
            DIGEST: if (digested) state <= ANSWER;
            default: if (answered || broadcast) state <= IDLE;
        endcase

        if (reset) state <= IDLE;
    end

    assign read_address = index[8:0];
    assign at_work = state != IDLE;
    assign passed = state == CHECK;
    assign answer = state == ANSWER && !broadcast;
    assign done = state == ANSWER && (answered || broadcast);

    wire ok = verdict == `RESULT_OK;
    assign restore = passed && ok && is_reset;
    assign digest = passed && ok && is_digest;
    assign let_go = state == LET_GO && index == 10'd0;

    wire commit = state == COMMIT;
    assign restart  = commit && is_reset;
    assign enable   = commit && is_enable;
    assign mute     = commit && packet_type == `TYPE_MUTE;
    assign baud     = commit && is_baud;
    assign stop     = commit && packet_type == `TYPE_STOP;
    assign rate     = commit && packet_type == `TYPE_RATE;
    assign silencer = commit && is_silencer;
    assign play     = commit && (is_play || ((is_phases || is_frame) && arguments[16]));
    assign play_first   = a0[SLOT_BITS-1:0];
    assign play_last    = is_play ? a1[SLOT_BITS-1:0] : a0[SLOT_BITS-1:0];
    assign play_divider = is_play ? high : 16'd1;
    assign play_loops   = is_play ? loops : 16'd0;
    assign play_begins  = is_play;
    assign play_when    = is_play ? when_asked[1:0] : arguments[17] ? `WHEN_IN_STEP : `WHEN_AT_ONCE;

    // In pairs, even bytes are phases and offsets, odd bytes amplitudes and gains.
    wire       write = state == COPY && index != 10'd0;
    wire [8:0] place = read_address - 9'd1;
    assign write_phase     = write && (is_phases || (is_frame && !place[0]));
    assign write_amplitude = write && (is_phases || (is_frame && place[0]));
    assign write_envelope  = write && packet_type == `TYPE_ENVELOPE;
    assign write_width     = write && packet_type == `TYPE_WIDTHS;
    assign write_offset    = write && packet_type == `TYPE_CALIBRATION && !place[0];
    assign write_gain      = write && packet_type == `TYPE_CALIBRATION && place[0];
    assign write_address   = pairs ? place[8:1] : place[7:0];
    assign write_data      = read_data;
    assign amplitude_written = is_phases ? a1 : read_data;
endmodule

`default_nettype wire
