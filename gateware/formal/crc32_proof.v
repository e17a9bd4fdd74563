// crc32 equals eight steps of the division, for every register and every byte.
`default_nettype none
module crc32_proof (input wire clk, input wire [31:0] from, input wire [7:0] data);
    wire [31:0] to;
    crc32 crc32 (.from(from), .data(data), .to(to));
    function [31:0] longer(input [31:0] start, input [7:0] value);
        integer i;
        begin
            longer = start ^ {24'd0, value};
            for (i = 0; i < 8; i = i + 1) longer = longer[0] ? {1'b0, longer[31:1]} ^ 32'hEDB88320 : {1'b0, longer[31:1]};
        end
    endfunction
    always @(posedge clk) begin
        assert (to == longer(from, data));
        cover (to == 32'hDEBB20E3);
    end
endmodule
