// UART transmitter, 8N1. A bit takes 65536 / increment clocks.
`default_nettype none

module uart_tx (
    input  wire        clk,
    input  wire        reset,
    input  wire [15:0] increment,
    input  wire        valid,       // take `data` if `ready`
    input  wire [7:0]  data,
    output wire        ready,
    output reg         txd
);
    reg [3:0]  left;        // bits to send, this one included
    reg [9:0]  bits;
    reg [15:0] part;        // of a bit, since it began
    wire [16:0] sum = {1'b0, part} + {1'b0, increment};

    assign ready = left == 4'd0;

    always @(posedge clk) begin
        txd <= ready || bits[0];
        if (ready) begin
            part <= 16'd0;
            bits <= {1'b1, data, 1'b0};
            if (valid) left <= 4'd10;
        end else begin
            part <= sum[15:0];
            if (sum[16]) begin
                bits <= {1'b1, bits[9:1]};
                left <= left - 4'd1;
            end
        end

        if (reset) begin
            left <= 4'd0;
            txd <= 1'b1;
        end
    end
endmodule

`default_nettype wire
