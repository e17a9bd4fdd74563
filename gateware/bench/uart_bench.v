// uart_tx into uart_rx at several rates, and an independent sender into uart_rx: fast and slow, noise, and missing stop
// bits.
`include "check.vh"
`timescale 1ns/1ps
module uart_bench;
    `include "bench.vh"
    reg         reset = 1, sends = 0, valid = 0;
    reg  [15:0] increment = 16'd3200;
    reg  [7:0]  data = 0;
    wire        ready, txd;
    reg         line = 1;
    uart_tx uart_tx (
        .clk(clk), .reset(reset), .increment(increment), .valid(valid), .data(data), .ready(ready), .txd(txd)
    );
    wire       received, framing;
    wire [7:0] byte_received;
    wire       rxd;
    synchroniser synchroniser (.clk(clk), .reset(reset), .from_outside(sends ? txd : line), .synchronised(rxd));
    uart_rx uart_rx (
        .clk(clk), .reset(reset), .increment(increment), .rxd(rxd),
        .valid(received), .data(byte_received), .framing(framing)
    );

    integer bytes = 0, framings = 0, wrong = 0;
    reg [7:0] expected [0:4095];
    integer told = 0;
    always @(posedge clk) begin
        if (received) begin
            if (byte_received !== expected[bytes]) wrong = wrong + 1;
            bytes = bytes + 1;
        end
        if (framing) framings = framings + 1;
    end

    task by_device(input [15:0] rate, input integer count);
        integer i, clocks;
        begin
            increment = rate;
            sends = 1;
            for (i = 0; i < count; i = i + 1) begin
                data = $random;
                expected[told] = data;
                told = told + 1;
                valid = 1;
                @(negedge clk);
                valid = 0;
                clocks = 1;
                while (!ready) begin
                    @(negedge clk);
                    clocks = clocks + 1;
                end
                // Ten bits, rounded up to clocks once, and the clock of acceptance.
                `CHECK("the clocks of a byte", clocks, 1 + (10 * 65536 + rate - 1) / rate)
            end
            repeat (4 + 65536 / rate) @(negedge clk);
            sends = 0;
        end
    endtask

    // A character with this bit time in ns.
    task by_host(input real bit_ns, input [7:0] value, input stop);
        integer i;
        begin
            line = 0;
            #(bit_ns);
            for (i = 0; i < 8; i = i + 1) begin
                line = value[i];
                #(bit_ns);
            end
            line = stop;
            #(bit_ns);
            line = 1;
        end
    endtask

    task host_bytes(input real bit_ns, input integer count);
        integer i;
        begin
            #(100);
            for (i = 0; i < count; i = i + 1) begin
                expected[told] = $random;
                told = told + 1;
                by_host(bit_ns, expected[told - 1], 1'b1);
            end
            #(2 * bit_ns);
        end
    endtask

    localparam real BIT = 10.0 * 65536 / 3200;  // ns, with the bench's clock of 10 ns
    initial begin
        repeat (4) @(negedge clk);
        reset = 0;
        repeat (4) @(negedge clk);

        by_device(16'd3200, 40);
        by_device(16'd4800, 40);
        by_device(16'd369, 10);
        by_device(16'd16384, 60);
        `CHECK("bytes from the device", bytes, 150)

        increment = 16'd3200;
        host_bytes(BIT, 40);
        host_bytes(BIT * 1.04, 40);
        host_bytes(BIT / 1.04, 40);
        `CHECK("bytes from the host", bytes, 270)
        `CHECK("wrong bytes", wrong, 0)
        `CHECK("framing errors so far", framings, 0)

        // A glitch of a third of a bit is not a start bit.
        line = 0;
        #(BIT / 3) line = 1;
        #(12 * BIT) `CHECK("bytes after noise", bytes, 270)
        // Without a stop bit: no byte, one framing error, and the next byte is received.
        by_host(BIT, 8'h55, 1'b0);
        #(2 * BIT) `CHECK("bytes without a stop bit", bytes, 270)
        `CHECK("framing errors", framings, 1)
        host_bytes(BIT, 1);
        // A line that stays low gives one framing error, for any duration.
        line = 0;
        #(50 * BIT) line = 1;
        #(2 * BIT) `CHECK("framing errors of a break", framings, 2)
        host_bytes(BIT, 1);
        `CHECK("bytes after the break", bytes, 272)
        `CHECK("wrong bytes at the end", wrong, 0)
        `END
    end
endmodule
