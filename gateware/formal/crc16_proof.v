// crc16 equals eight steps of the division, for every register and every byte.
`default_nettype none
module crc16_proof (input wire clk, input wire [15:0] from, input wire [7:0] data);
    wire [15:0] to;
    crc16 crc16 (.from(from), .data(data), .to(to));
    function [15:0] longer(input [15:0] start, input [7:0] value);
        integer i;
        begin
            longer = start ^ {value, 8'h00};
            for (i = 0; i < 8; i = i + 1) longer = longer[15] ? {longer[14:0], 1'b0} ^ 16'h1021 : {longer[14:0], 1'b0};
        end
    endfunction
    always @(posedge clk) begin
        assert (to == longer(from, data));
        cover (to == 16'h1D0F);
    end
endmodule
