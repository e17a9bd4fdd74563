// lanes through 32 shift registers: all outputs at all levels equal the written pulses, while other pulses are being
// written.
`include "check.vh"
module lanes_case #(parameter PHASE_BITS = 7, parameter PERIOD_BITS = 10) (input wire clk, input wire reset, output reg finished);
    integer errors = 0;
    wire        last, sweep, bank, count, boundary, gate;
    wire [PERIOD_BITS-1:0] ahead;
    wire [PERIOD_BITS-1:0] tick;
    wire period_ends, skips;
    ticks #(.PERIOD_BITS(PERIOD_BITS), .PHASE_BITS(PHASE_BITS)) ticks (
        .clk(clk), .reset(reset), .hold(1'b0), .skip(1'b0), .skips(skips), .tick(tick), .period_ends(period_ends), .last(last), .count(count), .boundary(boundary), .sweep(sweep), .gate(gate),
        .ahead(ahead), .bank(bank)
    );
    reg         write = 0;
    reg  [7:0]  channel = 0;
    reg  [PHASE_BITS-1:0] rise, width;
    wire [31:0] data;
    wire        shift, latch, sync;
    lanes #(.PERIOD_BITS(PERIOD_BITS), .PHASE_BITS(PHASE_BITS)) lanes (
        .clk(clk), .reset(reset), .ahead(ahead), .hold(1'b0), .bank(bank), .mark(1'b0), .write(write),
        .write_channel(channel), .write_rise(rise), .write_width(width),
        .data(data), .shift(shift), .latch(latch), .sync(sync)
    );

    // Pulses of the current period and of the next.
    localparam LEVELS = 1 << PHASE_BITS;
    reg [PHASE_BITS-1:0] playing_rise [0:255], playing_width [0:255], next_rise [0:255], next_width [0:255];
    // 74x595: bit 8 i + q is Qq of register i. They latch at the start of a clock and shift in its middle.
    reg  [255:0] shifted, outputs;
    reg          latch_before = 1;
    integer i, n, level = 0, periods = 0, levels_checked = 0;
    reg [PHASE_BITS-1:0] since;
    always @(negedge clk) begin
        if (latch && !latch_before) begin
            outputs = shifted;
            level = sync ? 0 : level + 1;
            if (periods > 2 && periods < 6) levels_checked = levels_checked + 1;
            if (periods > 2 && periods < 6) for (i = 0; i < 256; i = i + 1) begin
                since = level - playing_rise[i];
                `CHECK("an output", outputs[i], since < playing_width[i])
            end
        end
        latch_before = latch;
        if (shift) for (i = 0; i < 32; i = i + 1) shifted[8*i +: 8] = {shifted[8*i +: 7], data[i]};
        if (last) begin
            for (i = 0; i < 256; i = i + 1) begin
                playing_rise[i] = next_rise[i];
                playing_width[i] = next_width[i];
            end
            periods = periods + 1;
        end
    end

    initial begin
        finished = 0;
        while (periods < 6) begin
            @(negedge clk);
            if (sweep) begin
                #1 for (n = 0; n < 256; n = n + 1) begin
                    write = 1;
                    channel = n;
                    rise = $random;
                    width = $random;
                    width = n % 9 == 0 ? 0 : width % (LEVELS / 2 + 1);
                    next_rise[n] = rise;
                    next_width[n] = width;
                    @(posedge clk) #1;
                end
                write = 0;
            end
        end
        `CHECK("the levels that were checked", levels_checked, 3 * LEVELS)
        finished = errors == 0;
    end
endmodule

module lanes_bench;
    `include "bench.vh"
    reg reset = 1;
    wire [3:0] finished;
    lanes_case #(5, 10) five (clk, reset, finished[0]);
    lanes_case #(6, 10) six (clk, reset, finished[1]);
    lanes_case #(7, 10) seven (clk, reset, finished[2]);
    lanes_case #(8, 11) eight (clk, reset, finished[3]);
    initial begin
        repeat (3) @(negedge clk);
        #1 reset = 0;
        repeat (8 * 2048) @(negedge clk);
        `CHECK("finished", finished, 4'b1111)
        `END
    end
endmodule
