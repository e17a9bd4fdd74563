// One byte's step of CRC-16 GENIBUS: polynomial 0x1021, start 0xFFFF, highest bit first. The sender inverts all bits,
// so that over body and CRC the register ends at 0x1D0F.
`default_nettype none

module crc16 (
    input  wire [15:0] from,
    input  wire [7:0]  data,
    output wire [15:0] to
);
    // The polynomial's terms are 4 to 8 bits apart, which allows writing the eight steps at once.
    wire [7:0] mixed = from[15:8] ^ data;
    wire [7:0] folded = {mixed[7:4], mixed[3:0] ^ mixed[7:4]};
    assign to = {from[7:0], 8'h00} ^ {folded[3:0], 12'h000} ^ {3'b000, folded, 5'b00000} ^ {8'h00, folded};
endmodule

`default_nettype wire
