// A table of 256 bytes in block RAM: one port writes, one reads, a clock later. After configuration it holds `CONTENTS`, whose
// lowest byte is entry 0.
`default_nettype none

module table_256 #(
    parameter [2047:0] CONTENTS = 2048'd0
) (
    input  wire       clk,
    input  wire       write,
    input  wire [7:0] write_address,
    input  wire [7:0] write_data,
    input  wire [7:0] read_address,
    output reg  [7:0] read_data
);
    (* ram_style = "block" *)
    reg [7:0] cells [0:255];

    integer i;
    initial for (i = 0; i < 256; i = i + 1) cells[i] = CONTENTS[8*i +: 8];

    always @(posedge clk) begin
        if (write) cells[write_address] <= write_data;
        read_data <= cells[read_address];
    end
endmodule

`default_nettype wire
