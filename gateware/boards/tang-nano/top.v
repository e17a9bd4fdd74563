// The device on a Sipeed Tang Nano 9K (GW1NR-9) or 20K (GW2AR-18), both with an oscillator of 27 MHz. They differ in
// COPIES, the number of pins with SCLK and RCLK, in LEDS, and in their pins. ../clock.py finds the PLL settings.
`default_nettype none

module top #(
    parameter DEVICE = "GW2AR-18C",
    parameter COPIES = 2,
    parameter LEDS = 2,
    parameter OSCILLATOR_KHZ = 27000,
    parameter PLL_DIVIDE = 7,
    parameter MULTIPLY = 64,
    parameter OUT_DIVIDE = 6,
    parameter VCO_DIVIDE = 4,
    parameter PHASE_BITS = 7,
    parameter SLOT_BITS = 6
) (
    input  wire              oscillator,
    input  wire              rxd,
    output wire              txd,
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
    output wire [LEDS-1:0]   led_n
);
    // CLKOUT = oscillator / PLL_DIVIDE * MULTIPLY, and CLKOUTD = CLKOUT / OUT_DIVIDE: CLKOUT alone would be off by 1.1
    // % or more.
    wire clk, locked, pll_reset;
    rPLL #(
        .DEVICE(DEVICE), .FCLKIN("27"), .IDIV_SEL(PLL_DIVIDE - 1), .FBDIV_SEL(MULTIPLY - 1), .ODIV_SEL(VCO_DIVIDE),
        .DYN_SDIV_SEL(OUT_DIVIDE), .CLKOUTD_SRC("CLKOUT"), .CLKFB_SEL("internal")
    ) pll (
        .CLKIN(oscillator), .CLKFB(1'b0), .RESET(pll_reset), .RESET_P(1'b0),
        .FBDSEL(6'd0), .IDSEL(6'd0), .ODSEL(6'd0), .DUTYDA(4'd0), .PSDA(4'd0), .FDLY(4'd0),
        .CLKOUT(), .CLKOUTP(), .CLKOUTD(clk), .CLKOUTD3(), .LOCK(locked)
    );

    wire [31:0] data_inside;
    wire [1:0]  sclk_inside;
    wire        reset, rclk_inside, sync_inside, trigger_inside, on, tripped, packet;
    native #(
        .OSCILLATOR_KHZ(OSCILLATOR_KHZ), .MULTIPLY(MULTIPLY), .DIVIDE(PLL_DIVIDE * OUT_DIVIDE), .PHASE_BITS(PHASE_BITS),
        .SLOT_BITS(SLOT_BITS)
    ) native (
        .oscillator(oscillator), .clk(clk), .locked(locked), .pll_reset(pll_reset), .reset(reset),
        .rxd(rxd), .txd(txd), .estop_n(estop_n), .sync_in(sync_in), .trigger_in(trigger_in), .address(address),
        .data(data_inside), .sclk(sclk_inside), .rclk(rclk_inside), .oe_n(oe_n), .sync(sync_inside), .trigger(trigger_inside),
        .led_on(on), .led_tripped(tripped), .led_packet(packet)
    );
    wire [2:0] led = {packet, tripped, on};
    assign led_n = ~led[LEDS-1:0];

    // All outputs pass the same kind of register, which keeps their delays equal.
    genvar i;
    generate
        for (i = 0; i < 32; i = i + 1) begin : each_data
            ODDR register (.CLK(clk), .TX(1'b0), .D0(data_inside[i]), .D1(data_inside[i]), .Q0(data[i]), .Q1());
        end
        for (i = 0; i < COPIES; i = i + 1) begin : each_clock
            ODDR sclk_register (.CLK(clk), .TX(1'b0), .D0(sclk_inside[0]), .D1(sclk_inside[1]), .Q0(sclk[i]), .Q1());
            ODDR rclk_register (.CLK(clk), .TX(1'b0), .D0(rclk_inside), .D1(rclk_inside), .Q0(rclk[i]), .Q1());
        end
    endgenerate
    ODDR sync_register (.CLK(clk), .TX(1'b0), .D0(sync_inside), .D1(sync_inside), .Q0(sync), .Q1());
    ODDR trigger_register (.CLK(clk), .TX(1'b0), .D0(trigger_inside), .D1(trigger_inside), .Q0(trigger), .Q1());
endmodule

`default_nettype wire
