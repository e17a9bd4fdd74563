// The device on an LFE5U, such as a ULX3S'. The pin file decides which ports there are, and the number of COPIES of SCLK
// and RCLK; inputs without a pin are low. ../clock.py finds the PLL settings.
`default_nettype none

module top #(
    parameter OSCILLATOR_KHZ = 25000,
    parameter PLL_DIVIDE = 2,
    parameter MULTIPLY = 59,
    parameter OUT_DIVIDE = 18,
    parameter PHASE_BITS = 7,
    parameter SLOT_BITS = 6,
    parameter COPIES = 4
) (
    input  wire              oscillator,
    input  wire              rxd,       // from the host
    output wire              txd,       // to the host
    input  wire              estop_n,
    input  wire              sync_in,
    input  wire              trigger_in,
    input  wire [2:0]        address,
    output wire [31:0]       data,
    output wire [COPIES-1:0] sclk,
    output wire [COPIES-1:0] rclk,
    output wire              oe_n,
    output wire              sync,
    output wire              trigger,
    output wire [2:0]        led,
    output wire              held_high
);
    assign held_high = 1'b1;

    // CLKOS is the feedback: VCO = oscillator / PLL_DIVIDE * MULTIPLY, and CLKOP = VCO / OUT_DIVIDE.
    wire clk, feedback, locked, pll_reset;
    EHXPLLL #(
        .CLKI_DIV(PLL_DIVIDE), .CLKFB_DIV(1), .FEEDBK_PATH("CLKOS"), .PLLRST_ENA("ENABLED"),
        .CLKOP_ENABLE("ENABLED"), .CLKOP_DIV(OUT_DIVIDE), .CLKOP_CPHASE(OUT_DIVIDE - 1),
        .CLKOS_ENABLE("ENABLED"), .CLKOS_DIV(MULTIPLY), .CLKOS_CPHASE(MULTIPLY - 1)
    ) pll (
        .CLKI(oscillator), .CLKFB(feedback), .CLKOP(clk), .CLKOS(feedback), .LOCK(locked),
        .RST(pll_reset), .STDBY(1'b0), .PLLWAKESYNC(1'b0), .ENCLKOP(1'b0), .ENCLKOS(1'b0), .ENCLKOS2(1'b0), .ENCLKOS3(1'b0),
        .PHASESEL0(1'b0), .PHASESEL1(1'b0), .PHASEDIR(1'b0), .PHASESTEP(1'b0), .PHASELOADREG(1'b0)
    );

    wire [31:0] data_inside;
    wire [1:0]  sclk_inside;
    wire        reset, rclk_inside, sync_inside, trigger_inside;
    native #(
        .OSCILLATOR_KHZ(OSCILLATOR_KHZ), .MULTIPLY(MULTIPLY), .DIVIDE(PLL_DIVIDE * OUT_DIVIDE), .PHASE_BITS(PHASE_BITS),
        .SLOT_BITS(SLOT_BITS)
    ) native (
        .oscillator(oscillator), .clk(clk), .locked(locked), .pll_reset(pll_reset), .reset(reset),
        .rxd(rxd), .txd(txd), .estop_n(estop_n), .sync_in(sync_in), .trigger_in(trigger_in), .address(address),
        .data(data_inside), .sclk(sclk_inside), .rclk(rclk_inside), .oe_n(oe_n), .sync(sync_inside), .trigger(trigger_inside),
        .led_on(led[0]), .led_tripped(led[1]), .led_packet(led[2])
    );

    // All outputs pass the same kind of register, which keeps their delays equal.
    genvar i;
    generate
        for (i = 0; i < 32; i = i + 1) begin : each_data
            ODDRX1F register (.SCLK(clk), .RST(reset), .D0(data_inside[i]), .D1(data_inside[i]), .Q(data[i]));
        end
        for (i = 0; i < COPIES; i = i + 1) begin : each_clock
            ODDRX1F sclk_register (.SCLK(clk), .RST(reset), .D0(sclk_inside[0]), .D1(sclk_inside[1]), .Q(sclk[i]));
            ODDRX1F rclk_register (.SCLK(clk), .RST(reset), .D0(rclk_inside), .D1(rclk_inside), .Q(rclk[i]));
        end
    endgenerate
    ODDRX1F sync_register (.SCLK(clk), .RST(reset), .D0(sync_inside), .D1(sync_inside), .Q(sync));
    ODDRX1F trigger_register (.SCLK(clk), .RST(reset), .D0(trigger_inside), .D1(trigger_inside), .Q(trigger));
endmodule

`default_nettype wire
