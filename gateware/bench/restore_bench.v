// restore: after a reset and on request, every cell of the store and the tables is written with its power-up value, and
// it ends with the gate.
`include "check.vh"
module restore_bench;
    `include "bench.vh"
    reg         reset = 1, start = 0, open = 0;
    wire        waking, restored, write;
    wire [13:0] place;
    wire [7:0]  width;
    restore restore (
        .clk(clk), .reset(reset), .start(start), .open(open), .waking(waking), .restored(restored),
        .write(write), .place(place), .width(width)
    );
    reg [16383:0] written;
    reg [7:0]     widths [0:255];
    integer       ends = 0, i, clocks = 0;
    always @(posedge clk) begin
        if (write) begin
            written[place] = 1;
            widths[place[7:0]] = width;
        end
        if (restored) ends = ends + 1;
    end
    always @(negedge clk) begin
        clocks = clocks + 1;
        open = clocks % 1024 == 350;
    end
    // Three values and their order suffice: the CRC in Rust's tests covers the rest of the table.
    task whole(input integer count);
        begin
            written = 0;
            for (i = 0; i < 18 * 1024 && ends < count; i = i + 1) @(negedge clk);
            @(negedge clk) `CHECK("ends", ends, count)
            `CHECK("cells that were not written", &written, 1'b1)
            `CHECK("the first width", widths[0], 8'd0)
            `CHECK("a width", widths[128], 8'd43)
            `CHECK("the last width", widths[255], 8'd128)
            for (i = 1; i < 256; i = i + 1) `CHECK("a fall of widths", widths[i] < widths[i-1], 1'b0)
            repeat (3000) @(negedge clk) `CHECK("a write afterwards", write, 1'b0)
        end
    endtask
    initial begin
        repeat (3) @(negedge clk);
        reset = 0;
        @(negedge clk) `CHECK("waking", waking, 1'b1)
        whole(1);
        `CHECK("awake", waking, 1'b0)
        start = 1;
        @(negedge clk) start = 0;
        whole(2);
        `CHECK("awake still", waking, 1'b0)
        `END
    end
endmodule
