// The CRC-32 of a slot or a table, in the byte order of the packet that writes it. It reads the memories while no
// sweep runs.
`include "packets.vh"
`default_nettype none

module digest (
    input  wire        clk,
    input  wire        reset,
    input  wire        start,
    input  wire [1:0]  what,
    output reg         reading,     // the memories' cell at `address`, a clock later
    output wire [7:0]  address,
    input  wire [7:0]  phase,
    input  wire [7:0]  amplitude,
    input  wire [7:0]  envelope,
    input  wire [7:0]  width,
    input  wire [7:0]  offset,
    input  wire [7:0]  gain,
    output wire [31:0] crc,
    output wire        ready        // for one clock
);
    // Pairs take two clocks at each address.
    reg        pairs;
    reg [8:0]  index;
    reg        odd_1, valid_1, valid_2, valid_3;
    reg [7:0]  byte_2;
    reg [31:0] register;
    wire       ends = index == (pairs ? 9'd511 : 9'd255);
    assign address = pairs ? index[8:1] : index[7:0];

    wire [31:0] register_after;
    crc32 step (.from(register), .data(byte_2), .to(register_after));
    assign crc = ~register;
    assign ready = valid_3 && !valid_2;

    always @(posedge clk) begin
        if (start) pairs <= what == `DIGEST_SLOT || what == `DIGEST_CALIBRATION;
        index <= reading ? index + 9'd1 : 9'd0;
        if (start) reading <= 1'b1;
        else if (ends) reading <= 1'b0;

        odd_1 <= index[0];
        valid_1 <= reading;
        case (what)
            `DIGEST_SLOT:     byte_2 <= odd_1 ? amplitude : phase;
            `DIGEST_ENVELOPE: byte_2 <= envelope;
            `DIGEST_WIDTHS:   byte_2 <= width;
            default:          byte_2 <= odd_1 ? gain : offset;
        endcase
        valid_2 <= valid_1;
        valid_3 <= valid_2;
        if (start) register <= 32'hFFFFFFFF;
        else if (valid_2) register <= register_after;

        if (reset) begin
            reading <= 1'b0;
            index <= 9'd0;
            valid_1 <= 1'b0;
            valid_2 <= 1'b0;
            valid_3 <= 1'b0;
        end
    end
endmodule

`default_nettype wire
