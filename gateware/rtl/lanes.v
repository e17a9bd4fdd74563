// 32 lanes, each of which fills one 74x595 with a bit per channel and level. Channel 8 i + q is Qq of register i, so
// channel 7 of the eight is shifted first. A level is shifted in while the previous one is at the outputs; then
// `latch` rises.
`default_nettype none

module lanes #(
    parameter PERIOD_BITS = 10,
    parameter PHASE_BITS = 7
) (
    input  wire                   clk,
    input  wire                   reset,
    input  wire [PERIOD_BITS-1:0] ahead,
    input  wire                   hold,             // `ahead` waits
    input  wire                   bank,
    input  wire                   mark,             // this period's `sync` is twice as long
    input  wire                   write,            // into the other bank
    input  wire [7:0]             write_channel,
    input  wire [PHASE_BITS-1:0]  write_rise,
    input  wire [PHASE_BITS-1:0]  write_width,
    output wire [31:0]            data,
    output wire                   shift,            // the registers take `data` in the middle of this clock
    output wire                   latch,
    output wire                   sync              // high with level 0 at the outputs, and with level 1 if the period is marked
);
    // A bit takes 2^SLOW clocks and is shifted at its middle.
    localparam SLOW = PERIOD_BITS - PHASE_BITS - 3;
    localparam [SLOW:0] HALF = (1 << SLOW) >> 1;

    wire [PHASE_BITS-1:0] level = ahead[PERIOD_BITS-1:SLOW+3];
    wire [2:0]            bit_now = ahead[SLOW+2:SLOW];
    wire                  half;
    generate
        if (SLOW == 0) begin : fast
            assign half = 1'b1;
        end else begin : slow
            assign half = ahead[SLOW-1:0] == HALF[SLOW-1:0];
        end
    endgenerate

    reg [PHASE_BITS-1:0] level_held;
    always @(posedge clk) level_held <= level;

    genvar i;
    generate
        for (i = 0; i < 32; i = i + 1) begin : each
            lane #(.PHASE_BITS(PHASE_BITS)) lane (
                .clk(clk),
                .write(write && write_channel[7:3] == i),
                .write_address({!bank, write_channel[2:0]}),
                .write_pulse({write_rise, write_width}),
                .read_address({bank, ~bit_now}),
                .level(level_held),
                .high(data[i])
            );
        end
    endgenerate

    // Signals delayed together with the data.
    reg [2:0] shifts, latches, syncs;
    always @(posedge clk) begin
        shifts <= {shifts[1:0], half && !hold};
        latches <= {latches[1:0], !bit_now[2]};
        syncs <= {syncs[1:0], level == 1 || (mark && level == 2)};

        if (reset) begin
            shifts <= 3'd0;
            latches <= 3'd0;
            syncs <= 3'd0;
        end
    end
    assign shift = shifts[2];
    assign latch = latches[2];
    assign sync = syncs[2];
endmodule

`default_nettype wire
