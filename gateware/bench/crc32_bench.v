// crc32 against the same division bit by bit, and the catalogue's check value and residue of CRC-32/ISO-HDLC.
`include "check.vh"
module crc32_bench;
    `include "bench.vh"
    reg  [31:0] from;
    reg  [7:0]  data;
    wire [31:0] to;
    crc32 crc32 (.from(from), .data(data), .to(to));

    function [31:0] slow(input [31:0] start, input [7:0] value);
        integer i;
        begin
            slow = start ^ {24'd0, value};
            for (i = 0; i < 8; i = i + 1) slow = slow[0] ? (slow >> 1) ^ 32'hEDB88320 : slow >> 1;
        end
    endfunction

    integer i;
    initial begin
        for (i = 0; i < 20000; i = i + 1) begin
            from = $random;
            data = $random;
            #1 `CHECK("a step", to, slow(from, data))
        end
        from = 32'hFFFFFFFF;
        for (i = 0; i < 9; i = i + 1) begin
            data = "1" + i;
            #1 from = to;
        end
        `CHECK("the check value", ~from, 32'hCBF43926)
        for (i = 0; i < 4; i = i + 1) begin
            data = 32'hCBF43926 >> (8 * i);
            #1 from = to;
        end
        `CHECK("the residue", from, 32'hDEBB20E3)
        `END
    end
endmodule
