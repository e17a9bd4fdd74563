// What the device says of itself: counters, and the 14 bytes of an answer, one by one.
`include "packets.vh"
`default_nettype none

module status #(
    parameter PHASE_BITS = 7,
    parameter SLOT_BITS = 6,
    parameter [31:0] CARRIER_MHZ = 32'd40000000,
    parameter [7:0] LARGEST_BAUD = 8'd30       // in 100 000 baud
) (
    input  wire                 clk,
    input  wire                 reset,
    input  wire                 count,          // a period more
    input  wire                 good,           // a packet more
    input  wire                 spoiled,
    input  wire                 spoiled_by_line,
    input  wire [5:0]           flags,
    input  wire [SLOT_BITS-1:0] slot,
    input  wire                 about_spoiled,  // the answer is to a packet that was spoiled
    input  wire [7:0]           packet_type,
    input  wire [7:0]           packet_seq,
    input  wire [7:0]           result,
    input  wire [3:0]           index,
    output reg  [7:0]           value
);
    reg [15:0] good_packets, spoiled_packets;
    reg [7:0]  spoiled_lines;
    reg [31:0] periods;

    always @(posedge clk) begin
        if (count) periods <= periods + 32'd1;
        if (good) good_packets <= good_packets + 16'd1;
        if (spoiled) spoiled_packets <= spoiled_packets + 16'd1;
        if (spoiled && spoiled_by_line) spoiled_lines <= spoiled_lines + 8'd1;

        if (reset) begin
            periods <= 32'd0;
            good_packets <= 16'd0;
            spoiled_packets <= 16'd0;
            spoiled_lines <= 8'd0;
        end
    end

    localparam [7:0] LAST_SLOT = {8{1'b1}} >> (8 - SLOT_BITS);
    wire info = !about_spoiled && packet_type == `TYPE_INFO;

    always @* begin
        case (index)
            4'd0: value = about_spoiled ? `TYPE_ANSWER : packet_type + `TYPE_ANSWER;
            4'd1: value = about_spoiled ? 8'd0 : packet_seq;
            4'd2: value = about_spoiled ? `RESULT_CRC : result;
            4'd3: value = {2'd0, flags};
            4'd4: value = info ? `PROTOCOL_VERSION : {{8 - SLOT_BITS{1'b0}}, slot};
            4'd5: value = info ? PHASE_BITS[7:0] : spoiled_lines;
            4'd6: value = info ? LAST_SLOT : good_packets[7:0];
            4'd7: value = info ? `GATEWARE_VERSION : good_packets[15:8];
            4'd8: value = info ? CARRIER_MHZ[7:0] : spoiled_packets[7:0];
            4'd9: value = info ? CARRIER_MHZ[15:8] : spoiled_packets[15:8];
            4'd10: value = info ? CARRIER_MHZ[23:16] : periods[7:0];
            4'd11: value = info ? CARRIER_MHZ[31:24] : periods[15:8];
            4'd12: value = info ? 8'd255 : periods[23:16];
            default: value = info ? LARGEST_BAUD : periods[31:24];
        endcase
    end
endmodule

`default_nettype wire
