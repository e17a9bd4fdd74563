// The device on a Papilio Pro (XC6SLX9-2TQG144C, 32 MHz oscillator). ../clock.py finds the settings of the DCM_CLKGEN,
// which makes exactly 40.96 MHz from 32 MHz; no PLL of this family does. Synthesised with Yosys; not placed, not tried
// on hardware.
`default_nettype none

module top #(
    parameter OSCILLATOR_KHZ = 32000,
    parameter MULTIPLY = 32,
    parameter DIVIDE = 25,
    parameter PHASE_BITS = 7
) (
    input  wire        oscillator,
    input  wire        rxd,
    output wire        txd,
    input  wire        estop_n,
    input  wire        sync_in,
    input  wire        trigger_in,
    input  wire [1:0]  address,
    output wire [31:0] data,
    output wire [3:0]  sclk,
    output wire [3:0]  rclk,
    output wire        oe_n,
    output wire        sync,
    output wire        trigger,
    output wire        led
);
    localparam real PERIOD_NS = 1000000.0 / OSCILLATOR_KHZ;
    wire oscillator_inside, oscillator_pin, clk_made, clk, clk_n, locked, pll_reset;
    IBUFG oscillator_input (.I(oscillator), .O(oscillator_pin));
    BUFG oscillator_buffer (.I(oscillator_pin), .O(oscillator_inside));
    DCM_CLKGEN #(.CLKIN_PERIOD(PERIOD_NS), .CLKFX_MULTIPLY(MULTIPLY), .CLKFX_DIVIDE(DIVIDE)) generator (
        .CLKIN(oscillator_pin), .RST(pll_reset), .CLKFX(clk_made), .LOCKED(locked),
        .FREEZEDCM(1'b0), .PROGCLK(1'b0), .PROGDATA(1'b0), .PROGEN(1'b0),
        .CLKFX180(), .CLKFXDV(), .PROGDONE(), .STATUS()
    );
    BUFG clk_buffer (.I(clk_made), .O(clk));
    assign clk_n = !clk;

    wire [31:0] data_inside;
    wire [1:0]  sclk_inside;
    wire        reset, rclk_inside, sync_inside, trigger_inside, tripped, packet;
    native #(
        .OSCILLATOR_KHZ(OSCILLATOR_KHZ), .MULTIPLY(MULTIPLY), .DIVIDE(DIVIDE), .PHASE_BITS(PHASE_BITS)
    ) native (
        .oscillator(oscillator_inside), .clk(clk), .locked(locked), .pll_reset(pll_reset), .reset(reset),
        .rxd(rxd), .txd(txd), .estop_n(estop_n), .sync_in(sync_in), .trigger_in(trigger_in), .address({1'b0, address}),
        .data(data_inside), .sclk(sclk_inside), .rclk(rclk_inside), .oe_n(oe_n), .sync(sync_inside), .trigger(trigger_inside),
        .led_on(led), .led_tripped(tripped), .led_packet(packet)
    );

    // All outputs pass the same kind of register, which keeps their delays equal.
    wire [41:0] first = {{4{rclk_inside}}, {4{sclk_inside[0]}}, trigger_inside, sync_inside, data_inside};
    wire [41:0] second = {{4{rclk_inside}}, {4{sclk_inside[1]}}, trigger_inside, sync_inside, data_inside};
    wire [41:0] pins;
    assign {rclk, sclk, trigger, sync, data} = pins;
    genvar i;
    generate
        for (i = 0; i < 42; i = i + 1) begin : each
            ODDR2 #(.DDR_ALIGNMENT("C0"), .INIT(1'b0), .SRTYPE("SYNC")) register (
                .Q(pins[i]), .C0(clk), .C1(clk_n), .CE(1'b1), .D0(first[i]), .D1(second[i]), .R(reset), .S(1'b0)
            );
        end
    endgenerate
endmodule

`default_nettype wire
