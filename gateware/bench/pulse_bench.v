// pulse: all inputs with all numbers of phase bits, against integers.
`include "check.vh"
module pulse_case #(parameter PHASE_BITS = 7) (input wire start, output reg finished);
    integer errors = 0;
    reg  [7:0] middle, width_256;
    wire [PHASE_BITS-1:0] rise, width;
    pulse #(.PHASE_BITS(PHASE_BITS)) pulse (.middle(middle), .width_256(width_256), .rise(rise), .width(width));

    localparam LEVELS = 1 << PHASE_BITS;
    localparam PER_LEVEL = 256 / LEVELS;
    integer m, w, capped, doubled, expected_rise, expected_width, off;
    initial begin
        finished = 0;
        @(posedge start);
        for (m = 0; m < 256; m = m + 1) for (w = 0; w < 256; w = w + 1) begin
            {middle, width_256} = {m[7:0], w[7:0]};
            capped = w > 128 ? 128 : w;
            // Rounded to the nearest: the width, and the centre less half of that; adding 512 keeps numbers positive.
            expected_width = (capped + PER_LEVEL / 2) / PER_LEVEL;
            doubled = 512 + 2 * m - PER_LEVEL * expected_width + PER_LEVEL;
            expected_rise = (doubled / (2 * PER_LEVEL)) % LEVELS;
            #1 `CHECK("rise", rise, expected_rise[PHASE_BITS-1:0])
            `CHECK("width", width, expected_width[PHASE_BITS-1:0])
            if (2 * width > LEVELS) errors = errors + 1;
            // The centre, in half units of 1/256 period, is within half a level.
            off = (2 * PER_LEVEL * rise + PER_LEVEL * width - 2 * m + 1024 + 256) % 512 - 256;
            `CHECK("the centre", off <= PER_LEVEL && off >= -PER_LEVEL, 1'b1)
        end
        finished = errors == 0;
    end
endmodule

module pulse_bench;
    `include "bench.vh"
    reg start = 0;
    wire [3:0] finished;
    pulse_case #(5) five (start, finished[0]);
    pulse_case #(6) six (start, finished[1]);
    pulse_case #(7) seven (start, finished[2]);
    pulse_case #(8) eight (start, finished[3]);
    initial begin
        #1 start = 1;
        #70000 `CHECK("finished", finished, 4'b1111)
        `END
    end
endmodule
