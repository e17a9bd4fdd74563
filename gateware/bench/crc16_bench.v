// crc16 against the same division bit by bit, and the catalogue's check value of CRC-16 GENIBUS.
`include "check.vh"
module crc16_bench;
    `include "bench.vh"
    reg  [15:0] from;
    reg  [7:0]  data;
    wire [15:0] to;
    crc16 crc16 (.from(from), .data(data), .to(to));

    function [15:0] slow(input [15:0] start, input [7:0] value);
        integer i;
        begin
            slow = start ^ {value, 8'h00};
            for (i = 0; i < 8; i = i + 1) slow = slow[15] ? (slow << 1) ^ 16'h1021 : slow << 1;
        end
    endfunction

    integer i;
    initial begin
        for (i = 0; i < 20000; i = i + 1) begin
            from = $random;
            data = $random;
            #1 `CHECK("a step", to, slow(from, data))
        end
        from = 16'hFFFF;
        for (i = 0; i < 9; i = i + 1) begin
            data = "1" + i;
            #1 from = to;
        end
        `CHECK("the check value", ~from & 16'hFFFF, 16'hD64E)
        data = 8'hD6;
        #1 from = to;
        data = 8'h4E;
        #1 `CHECK("the residue", to, 16'h1D0F)
        `END
    end
endmodule
