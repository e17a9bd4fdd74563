// Common to all boards: the device, its reset, and the parameters of its clock, which is oscillator * MULTIPLY /
// DIVIDE.
`default_nettype none

module native #(
    parameter OSCILLATOR_KHZ = 25000,
    parameter MULTIPLY = 59,
    parameter DIVIDE = 36,
    parameter PHASE_BITS = 7,
    parameter SLOT_BITS = 6
) (
    input  wire        oscillator,
    input  wire        clk,
    /* verilator lint_off SYNCASYNCNET */
    input  wire        locked,      // used with a clock and without, on purpose
    /* verilator lint_on SYNCASYNCNET */
    output wire        pll_reset,
    output wire        reset,
    input  wire        rxd,
    output wire        txd,
    input  wire        estop_n,
    input  wire        sync_in,
    input  wire        trigger_in,
    input  wire [2:0]  address,
    output wire [31:0] data,
    output wire [1:0]  sclk,        // in the first and in the second half of the clock
    output wire        rclk,
    output wire        oe_n,
    output wire        sync,
    output wire        trigger,
    output wire        led_on,
    output wire        led_tripped,
    output wire        led_packet
);
    localparam [63:0] CLOCKS = PHASE_BITS == 8 ? 64'd2048 : 64'd1024;
    localparam [63:0] UP = OSCILLATOR_KHZ * MULTIPLY, DOWN = DIVIDE;
    // The clock is UP / DOWN kHz. Both are rounded: 10^6 * clock / CLOCKS in mHz, and 65536 * 2000 kHz / clock.
    localparam [63:0] CARRIER = (64'd1000000 * UP + DOWN * CLOCKS / 64'd2) / (DOWN * CLOCKS);
    // A bit needs five clocks.
    localparam [63:0] FIVE = UP / (DOWN * 64'd500), LARGEST_BAUD = FIVE < 64'd80 ? FIVE : 64'd80;
    localparam [63:0] INCREMENT = (64'd131072000 * DOWN + UP / 64'd2) / UP;

    power_up power_up (.oscillator(oscillator), .clk(clk), .locked(locked), .pll_reset(pll_reset), .reset(reset));

    wire shift, oe_n_inside;
    device #(
        .PHASE_BITS(PHASE_BITS), .SLOT_BITS(SLOT_BITS), .CARRIER_MHZ(CARRIER[31:0]), .FIRST_INCREMENT(INCREMENT[15:0]),
        .LARGEST_BAUD(LARGEST_BAUD[7:0]),
        .SYNC_LATENCY(3)    // the boards' output register is one clock
    ) device (
        .clk(clk), .reset(reset), .rxd(rxd), .txd(txd), .estop_n(estop_n), .sync_in(sync_in), .trigger_in(trigger_in), .address(address),
        .data(data), .shift(shift), .latch(rclk), .oe_n(oe_n_inside), .sync(sync), .trigger(trigger),
        .led_on(led_on), .led_tripped(led_tripped), .led_packet(led_packet)
    );
    assign oe_n = oe_n_inside || !locked;

    // SCLK rises in the middle of a bit. For bits of one clock this is the middle of the clock; for longer bits, SCLK
    // is high for a whole clock from the bit's middle, since 74HC595 need pulses longer than half a clock.
    assign sclk = PHASE_BITS < 7 ? {shift, shift} : {shift, 1'b0};
endmodule

`default_nettype wire
