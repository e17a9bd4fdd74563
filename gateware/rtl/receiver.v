// From bytes to packets: undoes COBS, checks the CRC, and keeps up to four good packets for this device until
// processed. Payloads are buffered, so no part of a packet takes effect before its CRC is verified. INFO of version 1
// is recognised.
`include "packets.vh"
`default_nettype none

module receiver (
    input  wire        clk,
    input  wire        reset,
    input  wire        valid,           // a byte has come
    input  wire [7:0]  data,
    input  wire        framing,         // a framing error
    input  wire [2:0]  address,         // of this device

    output wire        ready,           // a good packet waits
    output wire        broadcast,       // it is for all devices
    output wire [7:0]  packet_type,
    output wire [7:0]  packet_seq,
    output wire [31:0] arguments,       // a0 lowest
    output wire [9:0]  length,          // of the payload
    input  wire [8:0]  read_address,    // in its payload
    output wire [7:0]  read_data,       // a clock later
    input  wire        done,            // forget this packet

    output reg         good,            // for one clock: a packet was good
    output reg         spoiled,         // for one clock: a packet was not
    output reg         spoiled_by_line, // beside it: by a framing error
    output reg         old_info,        // beside it: it was INFO of version 1
    output reg  [7:0]  old_seq
);
    localparam [9:0] HEADER = 10'd7;
    localparam [9:0] CRC = 10'd4;
    localparam [9:0] LONGEST = 10'd523;
    localparam [31:0] RESIDUE = 32'hDEBB20E3;
    localparam [9:0] OLD_INFO = 10'd8;
    localparam [15:0] OLD_RESIDUE = 16'h1D0F;

    // The packet being received.
    reg [7:0]  left;        // bytes until the next code of COBS
    reg        whole;       // the block holds 254 bytes: no zero follows it
    reg        empty;       // nothing has come since the last delimiter
    reg        bad, bad_line;
    reg        crowded;     // there was no room for it
    reg [9:0]  count;       // decoded bytes
    reg [31:0] crc;
    reg [15:0] old_crc;
    reg [55:0] header;      // type lowest, address, seq, arguments

    // Waiting packets.
    reg [1:0]  first, next;
    reg [2:0]  waiting;
    reg [58:0] headers [0:3];
    wire       room = !waiting[2];

    wire delimiter = valid && data == 8'd0;
    wire at_code   = left == 8'd0;
    wire decoded   = valid && !delimiter && (!at_code || (!empty && !whole));
    wire [7:0] byte_decoded = at_code ? 8'd0 : data;
    wire in_header = count < HEADER;
    wire [9:0] place = count - HEADER;

    wire [31:0] crc_after;
    wire [15:0] old_crc_after;
    crc32 check (.from(crc), .data(byte_decoded), .to(crc_after));
    crc16 old_check (.from(old_crc), .data(byte_decoded), .to(old_crc_after));

    wire ends  = delimiter && !empty;
    wire whole_packet = !bad && at_code && crc == RESIDUE && count >= HEADER + CRC;
    wire for_all = header[15:8] == `BROADCAST;
    wire for_us = (for_all || header[15:8] == {5'd0, address}) && !header[7];
    wire accepted = ends && whole_packet && for_us && !crowded;
    wire is_spoiled = ends && (!whole_packet || (for_us && crowded));
    wire is_old_info = !bad && at_code && old_crc == OLD_RESIDUE && count == OLD_INFO && header[7:0] == `TYPE_INFO;

    ram #(.ADDRESS_BITS(11), .WIDTH(8)) payloads (
        .clk(clk),
        .write(decoded && room && !in_header && !place[9]),
        .write_address({next, place[8:0]}),
        .write_data(byte_decoded),
        .read_address({first, read_address}),
        .read_data(read_data)
    );

    always @(posedge clk) begin
        if (valid) begin
            empty <= delimiter;
            left <= delimiter ? 8'd0 : at_code ? data - 8'd1 : left - 8'd1;
            if (at_code) whole <= data == 8'hFF;
        end
        if (decoded) begin
            crc <= crc_after;
            old_crc <= old_crc_after;
            if (count != 10'h3FF) count <= count + 10'd1;
            if (in_header) header <= {byte_decoded, header[55:8]};
            if (count >= LONGEST) bad <= 1'b1;
            if (!room) crowded <= 1'b1;
        end
        if (framing) begin
            empty <= 1'b0;
            bad <= 1'b1;
            bad_line <= 1'b1;
        end

        good <= accepted;
        spoiled <= is_spoiled;
        spoiled_by_line <= is_spoiled && bad_line;
        old_info <= is_spoiled && is_old_info;
        if (is_spoiled) old_seq <= header[15:8];

        if (reset || delimiter) begin
            left <= 8'd0;
            empty <= 1'b1;
            whole <= 1'b0;
            bad <= 1'b0;
            bad_line <= 1'b0;
            crowded <= 1'b0;
            count <= 10'd0;
            crc <= 32'hFFFFFFFF;
            old_crc <= 16'hFFFF;
        end
        if (reset) begin
            good <= 1'b0;
            spoiled <= 1'b0;
        end
    end

    always @(posedge clk) begin
        if (accepted) begin
            headers[next] <= {for_all, count - HEADER - CRC, header[55:16], header[7:0]};
            next <= next + 2'd1;
        end
        if (done) first <= first + 2'd1;
        waiting <= waiting + {2'b00, accepted} - {2'b00, done};

        if (reset) begin
            first <= 2'd0;
            next <= 2'd0;
            waiting <= 3'd0;
        end
    end

    assign ready = waiting != 3'd0;
    assign {broadcast, length, arguments, packet_seq, packet_type} = headers[first];
endmodule

`default_nettype wire
