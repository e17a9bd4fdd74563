// A block RAM: one port writes, one reads, a clock later. Its initial content is never used.
`default_nettype none

module ram #(
    parameter ADDRESS_BITS = 8,
    parameter WIDTH = 8
) (
    input  wire                    clk,
    input  wire                    write,
    input  wire [ADDRESS_BITS-1:0] write_address,
    input  wire [WIDTH-1:0]        write_data,
    input  wire [ADDRESS_BITS-1:0] read_address,
    output reg  [WIDTH-1:0]        read_data
);
    (* ram_style = "block" *)
    reg [WIDTH-1:0] cells [0:(1<<ADDRESS_BITS)-1];

    always @(posedge clk) begin
        if (write) cells[write_address] <= write_data;
        read_data <= cells[read_address];
    end
endmodule

`default_nettype wire
