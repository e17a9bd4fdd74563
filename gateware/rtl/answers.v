// Writes answers, 16 bytes and their CRC, into a store for four of them, and sends them in sequence, COBS-encoded, to
// the UART. Answers in version 1's form have 14 bytes and their own CRC. Answers without room are dropped.
`default_nettype none

module answers (
    input  wire       clk,
    input  wire       reset,

    input  wire       ask,              // answer the packet in the gate, until `answered`
    output wire       answered,
    input  wire       silent,           // count spoiled packets without answering
    input  wire       spoiled,          // a packet was spoiled: answer that
    input  wire       spoiled_by_line,
    input  wire       old_info,         // beside `spoiled`: in version 1's form
    output wire       count_spoiled,    // for one clock, when the answer to it begins
    output wire       count_spoiled_by_line,
    output reg        about_spoiled,
    output reg        about_old,
    output wire [4:0] index,            // of the requested byte of the answer
    input  wire [7:0] value,            // a clock later

    output wire       send,
    output wire [7:0] sent,
    input  wire       line_ready,
    output wire       idle              // nothing to answer and nothing to send
);
    localparam [2:0] WAIT = 0, SCAN = 1, CODE = 2, BYTES = 3, END = 4;

    localparam [4:0] LENGTH = 5'd20, OLD_LENGTH = 5'd16;

    // The store.
    reg [7:0]  bytes [0:127];
    reg [3:0]  is_old;
    reg [1:0]  first, next;
    reg [2:0]  held;

    // Writing: bytes are requested, and arrive a clock later.
    reg        asking, writing, keep, spoiled_waits, by_line, old_waits;
    reg [4:0]  asked, place;
    reg [31:0] crc;
    reg [15:0] old_crc;
    wire [31:0] crc_after;
    wire [15:0] old_crc_after;
    wire [4:0] length = about_old ? OLD_LENGTH : LENGTH;
    wire       last = writing && place == length - 5'd1;
    wire       free = !asking && !writing;
    wire       starts = free && (spoiled_waits ? !silent : ask);
    wire       in_crc = place >= (about_old ? OLD_LENGTH - 5'd2 : LENGTH - 5'd4);
    wire [7:0] written = !in_crc ? value : about_old ? ~old_crc[15:8] : ~crc[7:0];
    crc32 check (.from(crc), .data(value), .to(crc_after));
    crc16 old_check (.from(old_crc), .data(value), .to(old_crc_after));

    assign index = asked;
    assign answered = last && !about_spoiled;
    assign count_spoiled = free && spoiled_waits;
    assign count_spoiled_by_line = by_line;

    always @(posedge clk) begin
        if (starts) begin
            asking <= 1'b1;
            keep <= !held[2];
            about_spoiled <= spoiled_waits;
            about_old <= spoiled_waits && old_waits;
        end
        if (free) spoiled_waits <= 1'b0;
        if (asking && asked == length - 5'd1) asking <= 1'b0;
        asked <= asking ? asked + 5'd1 : 5'd0;
        writing <= asking;
        place <= asked;
        crc <= !writing ? 32'hFFFFFFFF : in_crc ? {8'd0, crc[31:8]} : crc_after;
        old_crc <= !writing ? 16'hFFFF : in_crc ? {old_crc[7:0], 8'd0} : old_crc_after;

        if (spoiled) begin
            spoiled_waits <= 1'b1;
            by_line <= spoiled_by_line;
            old_waits <= old_info;
        end

        if (reset) begin
            asking <= 1'b0;
            writing <= 1'b0;
            spoiled_waits <= 1'b0;
        end
    end
    always @(posedge clk) begin
        if (writing && keep) bytes[{next, place}] <= written;
        if (last) is_old[next] <= about_old;
    end

    // Sending: `from` is the next byte, `zero` the place of the next zero, or the end.
    reg [2:0]  state;
    reg [4:0]  from, zero;
    wire [4:0] end_of_it = is_old[first] ? OLD_LENGTH : LENGTH;
    wire       at_end = zero == end_of_it;
    wire [4:0] looked_at = state == SCAN ? zero : from;
    // The byte read in the clock before, and its place.
    reg [7:0]  held_byte;
    reg [6:0]  held_place;
    wire       is_it = held_place == {first, looked_at};
    always @(posedge clk) begin
        held_byte <= bytes[{first, looked_at}];
        held_place <= {first, looked_at};
    end
    wire [4:0] code = zero - from + 5'd1;
    wire       sent_all = state == END && line_ready;

    assign send = state == CODE || (state == BYTES && from != zero && is_it) || state == END;
    assign sent = state == CODE ? {3'd0, code} : state == END ? 8'd0 : held_byte;
    assign idle = free && !spoiled_waits && held == 3'd0 && line_ready;

    always @(posedge clk) begin
        case (state)
            WAIT: begin
                from <= 5'd0;
                zero <= 5'd0;
                if (held != 3'd0) state <= SCAN;
            end
            SCAN: if (at_end || (is_it && held_byte == 8'd0)) state <= CODE; else if (is_it) zero <= zero + 5'd1;
            CODE: if (line_ready) state <= BYTES;
            BYTES: if (from == zero) begin
                from <= zero + 5'd1;
                zero <= zero + 5'd1;
                state <= at_end ? END : SCAN;
            end else if (line_ready && is_it) from <= from + 5'd1;
            default: if (line_ready) state <= WAIT;
        endcase

        if (sent_all) first <= first + 2'd1;
        if (last && keep) next <= next + 2'd1;
        held <= held + {2'b00, last && keep} - {2'b00, sent_all};

        if (reset) begin
            state <= WAIT;
            first <= 2'd0;
            next <= 2'd0;
            held <= 3'd0;
        end
    end
endmodule

`default_nettype wire
