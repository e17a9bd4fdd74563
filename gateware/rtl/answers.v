// Writes answers, 14 bytes and their CRC, into a store for four of them, and sends them one after the other, with COBS, to the UART.
// An answer for which there is no room is dropped.
`default_nettype none

module answers (
    input  wire       clk,
    input  wire       reset,

    input  wire       ask,              // answer the packet in the gate, until `answered`
    output wire       answered,
    input  wire       spoiled,          // a packet was spoiled: answer that
    input  wire       spoiled_by_line,
    output wire       count_spoiled,    // for one clock, when the answer to it begins
    output wire       count_spoiled_by_line,
    output reg        about_spoiled,
    output wire [3:0] index,            // which byte of the answer is asked for
    input  wire [7:0] value,

    output wire       send,
    output wire [7:0] sent,
    input  wire       line_ready,
    output wire       idle              // nothing to answer and nothing to send
);
    localparam [2:0] WAIT = 0, SCAN = 1, CODE = 2, BYTES = 3, END = 4;

    // The store.
    (* ram_style = "distributed" *)
    reg [7:0]  bytes [0:63];
    reg [1:0]  first, next;
    reg [2:0]  held;

    // Writing.
    reg        writing, keep, spoiled_waits, by_line;
    reg [3:0]  place;
    reg [15:0] crc;
    wire [15:0] crc_after;
    wire       last = writing && place == 4'd15;
    wire       starts = !writing && (spoiled_waits || ask);
    wire       in_crc = place[3:1] == 3'b111;
    wire [7:0] written = in_crc ? ~(place[0] ? crc[7:0] : crc[15:8]) : value;
    crc16 check (.before(crc), .data(value), .after(crc_after));

    assign index = place;
    assign answered = last && !about_spoiled;
    assign count_spoiled = !writing && spoiled_waits;
    assign count_spoiled_by_line = by_line;

    always @(posedge clk) begin
        if (starts) begin
            writing <= 1'b1;
            keep <= !held[2];
            about_spoiled <= spoiled_waits;
            spoiled_waits <= 1'b0;
        end
        if (last) writing <= 1'b0;
        place <= writing ? place + 4'd1 : 4'd0;
        if (!writing) crc <= 16'hFFFF;
        else if (!in_crc) crc <= crc_after;

        if (spoiled) begin
            spoiled_waits <= 1'b1;
            by_line <= spoiled_by_line;
        end

        if (reset) begin
            writing <= 1'b0;
            spoiled_waits <= 1'b0;
        end
    end
    always @(posedge clk) if (writing && keep) bytes[{next, place}] <= written;

    // Sending: `from` is the byte that is next, `zero` the next place of a zero, or the end.
    reg [2:0]  state;
    reg [4:0]  from, zero;
    wire [3:0] looked_at = state == SCAN ? zero[3:0] : from[3:0];
    wire [7:0] held_byte = bytes[{first, looked_at}];
    wire [4:0] code = zero - from + 5'd1;
    wire       sent_all = state == END && line_ready;

    assign send = state == CODE || (state == BYTES && from != zero) || state == END;
    assign sent = state == CODE ? {3'd0, code} : state == END ? 8'd0 : held_byte;
    assign idle = !writing && !spoiled_waits && held == 3'd0 && line_ready;

    always @(posedge clk) begin
        case (state)
            WAIT: begin
                from <= 5'd0;
                zero <= 5'd0;
                if (held != 3'd0) state <= SCAN;
            end
            SCAN: if (zero[4] || held_byte == 8'd0) state <= CODE; else zero <= zero + 5'd1;
            CODE: if (line_ready) state <= BYTES;
            BYTES: if (from == zero) begin
                from <= zero + 5'd1;
                zero <= zero + 5'd1;
                state <= zero[4] ? END : SCAN;
            end else if (line_ready) from <= from + 5'd1;
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
