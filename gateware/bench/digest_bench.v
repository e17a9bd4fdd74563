// digest: the CRC-32 of each table's bytes in order, repeatedly, with memories that answer a clock after the address.
`include "check.vh"
module digest_bench;
    `include "bench.vh"
    reg         reset = 1, start = 0;
    reg  [1:0]  what = 0;
    wire        reading, ready;
    wire [7:0]  address;
    wire [31:0] crc;
    reg  [7:0]  phase, amplitude, envelope, width, offset, gain;
    digest digest (
        .clk(clk), .reset(reset), .start(start), .what(what), .reading(reading), .address(address),
        .phase(phase), .amplitude(amplitude), .envelope(envelope), .width(width), .offset(offset), .gain(gain),
        .crc(crc), .ready(ready)
    );
    // Different bytes in each memory.
    function [7:0] held(input integer which, input [7:0] at);
        held = (at * (2 * which + 3)) ^ (at >> 3) ^ (which * 77);
    endfunction
    always @(posedge clk) begin
        {phase, amplitude} <= {held(0, address), held(1, address)};
        {envelope, width} <= {held(2, address), held(3, address)};
        {offset, gain} <= {held(4, address), held(5, address)};
    end
    integer    i, j, n, clocks;
    reg [31:0] expected;
    reg [7:0]  value;
    task one(input [1:0] asked);
        begin
            what = asked;
            expected = 32'hFFFFFFFF;
            n = asked == 0 || asked == 3 ? 512 : 256;
            for (i = 0; i < n; i = i + 1) begin
                case (asked)
                    0: value = held(i % 2, i / 2);
                    1: value = held(2, i);
                    2: value = held(3, i);
                    default: value = held(4 + i % 2, i / 2);
                endcase
                expected = expected ^ {24'd0, value};
                for (j = 0; j < 8; j = j + 1) expected = expected[0] ? (expected >> 1) ^ 32'hEDB88320 : expected >> 1;
            end
            start = 1;
            @(negedge clk) start = 0;
            clocks = 1;
            while (!ready) begin
                @(negedge clk);
                clocks = clocks + 1;
            end
            `CHECK("the CRC", crc, ~expected)
            `CHECK("reading at the end", reading, 1'b0)
            `CHECK("more clocks than a period leaves", clocks > 530, 1'b0)
            repeat (5) @(negedge clk) `CHECK("ready twice", ready, 1'b0)
            `CHECK("the CRC later", crc, ~expected)
        end
    endtask
    initial begin
        repeat (3) @(negedge clk);
        reset = 0;
        repeat (2) begin
            one(0);
            one(1);
            one(3);
            one(2);
        end
        `END
    end
endmodule
