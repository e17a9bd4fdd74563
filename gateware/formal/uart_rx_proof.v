// uart_rx at four clocks per bit: every byte has a start bit and a stop bit, and equals the line between them.
`default_nettype none
module uart_rx_proof (input wire clk, input wire rxd);
    reg reset = 1'b1;
    always @(posedge clk) reset <= 1'b0;

    wire valid, framing;
    wire [7:0] data;
    uart_rx uart_rx (
        .clk(clk), .reset(reset), .increment(16'd16384), .rxd(rxd), .valid(valid), .data(data), .framing(framing)
    );

    // The line at earlier clocks, the last one at 0.
    reg [36:0] line;
    always @(posedge clk) line <= {line[35:0], rxd};
    wire [7:0] bits = {line[4], line[8], line[12], line[16], line[20], line[24], line[28], line[32]};

    always @(posedge clk) if (!reset) begin
        if (valid) assert (line[0] && !line[36] && data == bits);
        if (framing) assert (!line[0] && !line[36] && !valid);
        cover (valid && data == 8'hA5);
        cover (framing);
    end
endmodule
