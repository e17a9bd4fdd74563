// One byte's step of CRC-32: zlib's, lowest bit first, start 0xFFFFFFFF. The sender inverts all bits, so that over
// body and CRC the register ends at 0xDEBB20E3.
`default_nettype none

module crc32 (
    input  wire [31:0] from,
    input  wire [7:0]  data,
    output wire [31:0] to
);
    // The effect of eight steps on each single bit; the division is linear.
    wire [7:0] mixed = from[7:0] ^ data;
    assign to = {8'h00, from[31:8]}
        ^ ({32{mixed[0]}} & 32'h77073096) ^ ({32{mixed[1]}} & 32'hEE0E612C)
        ^ ({32{mixed[2]}} & 32'h076DC419) ^ ({32{mixed[3]}} & 32'h0EDB8832)
        ^ ({32{mixed[4]}} & 32'h1DB71064) ^ ({32{mixed[5]}} & 32'h3B6E20C8)
        ^ ({32{mixed[6]}} & 32'h76DC4190) ^ ({32{mixed[7]}} & 32'hEDB88320);
endmodule

`default_nettype wire
