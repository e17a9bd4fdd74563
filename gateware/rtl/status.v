// The device's status: counters, and the 16 bytes of an answer before its CRC, one by one, or the 14 of version 1.
`include "packets.vh"
`default_nettype none

module status #(
    parameter PHASE_BITS = 7,
    parameter SLOT_BITS = 6,
    parameter [31:0] CARRIER_MHZ = 32'd40000000,
    parameter [7:0] LARGEST_BAUD = 8'd80       // in 100 000 baud
) (
    input  wire                 clk,
    input  wire                 reset,
    input  wire                 count,          // a period more
    input  wire                 good,           // a packet more
    input  wire                 spoiled,
    input  wire                 spoiled_by_line,
    input  wire [2:0]           address,
    input  wire [7:0]           flags,
    input  wire [SLOT_BITS-1:0] slot,
    input  wire                 about_spoiled,  // the answer is to a packet that was spoiled
    input  wire                 about_old,      // it is to INFO of version 1
    input  wire [7:0]           old_seq,
    input  wire [7:0]           packet_type,
    input  wire [7:0]           packet_seq,
    input  wire [7:0]           result,
    input  wire [31:0]          digest,
    input  wire [4:0]           index,
    output reg  [7:0]           value           // a clock later
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

    wire [7:0] slot_now;
    generate
        if (SLOT_BITS == 8) begin : all
            assign slot_now = slot;
        end else begin : some
            assign slot_now = {{8 - SLOT_BITS{1'b0}}, slot};
        end
    endgenerate

    localparam [7:0] LAST_SLOT = {8{1'b1}} >> (8 - SLOT_BITS);
    wire info = about_old || (!about_spoiled && packet_type == `TYPE_INFO);
    wire digested = !about_spoiled && packet_type == `TYPE_DIGEST && result == `RESULT_OK;
    wire [31:0] last = digested ? digest : periods;

    // Version 1 has no address, so all later bytes are one position earlier.
    wire [4:0] place = about_old && index != 5'd0 ? index + 5'd1 : index;
    always @(posedge clk) begin
        case (place)
            5'd0: value <= about_old ? `TYPE_INFO + `TYPE_ANSWER : about_spoiled ? `TYPE_ANSWER : packet_type + `TYPE_ANSWER;
            5'd1: value <= {5'd0, address};
            5'd2: value <= about_old ? old_seq : about_spoiled ? 8'd0 : packet_seq;
            5'd3: value <= about_old ? `RESULT_UNKNOWN : about_spoiled ? `RESULT_CRC : result;
            5'd4: value <= about_old ? {2'd0, flags[5:0]} : flags;
            5'd5: value <= info ? `PROTOCOL_VERSION : slot_now;
            5'd6: value <= info ? PHASE_BITS[7:0] : spoiled_lines;
            5'd7: value <= info ? LAST_SLOT : good_packets[7:0];
            5'd8: value <= info ? `GATEWARE_VERSION : good_packets[15:8];
            5'd9: value <= info ? CARRIER_MHZ[7:0] : spoiled_packets[7:0];
            5'd10: value <= info ? CARRIER_MHZ[15:8] : spoiled_packets[15:8];
            5'd11: value <= info ? CARRIER_MHZ[23:16] : last[7:0];
            5'd12: value <= info ? CARRIER_MHZ[31:24] : last[15:8];
            5'd13: value <= info ? 8'd255 : last[23:16];
            5'd14: value <= info ? LARGEST_BAUD : last[31:24];
            default: value <= 8'd0;
        endcase
    end
endmodule

`default_nettype wire
