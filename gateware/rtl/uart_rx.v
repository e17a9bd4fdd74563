// UART receiver, 8N1. The bit clock is a 16-bit accumulator: a bit takes 65536 / increment clocks. Every bit is
// sampled once, in its middle; a start bit that has ended by then is noise, and a low stop bit is a framing error.
`default_nettype none

module uart_rx (
    input  wire        clk,
    input  wire        reset,
    input  wire [15:0] increment,
    input  wire        rxd,         // in our clock already
    output reg         valid,       // for one clock: `data` has come
    output reg  [7:0]  data,
    output reg         framing      // for one clock: a framing error
);
    reg        receiving;
    reg        high_since;  // the line has been high since the last character
    reg [3:0]  bits;        // sampled so far, the start bit included
    reg [15:0] part;        // of a bit, since the last sample
    wire [16:0] sum = {1'b0, part} + {1'b0, increment};
    wire       sample = receiving && sum[16];

    always @(posedge clk) begin
        part <= receiving ? sum[15:0] : 16'h8000;
        valid <= 1'b0;
        framing <= 1'b0;
        if (rxd) high_since <= 1'b1;

        if (!receiving) begin
            bits <= 4'd0;
            receiving <= high_since && !rxd;
        end else if (sample) begin
            bits <= bits + 4'd1;
            if (bits == 4'd0) begin
                receiving <= !rxd;
            end else if (bits == 4'd9) begin
                receiving <= 1'b0;
                high_since <= rxd;
                valid <= rxd;
                framing <= !rxd;
            end else begin
                data <= {rxd, data[7:1]};
            end
        end

        if (reset) begin
            receiving <= 1'b0;
            high_since <= 1'b0;
            valid <= 1'b0;
            framing <= 1'b0;
        end
    end
endmodule

`default_nettype wire
