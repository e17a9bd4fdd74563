// The device on an ULX3S with an LFE5U-25F (25 MHz oscillator): a clock of 40.972 MHz, and the outputs on its headers J1 and J2.
`default_nettype none

module top (
    input  wire        clk_25mhz,
    input  wire        ftdi_txd,    // from the host
    output wire        ftdi_rxd,    // to the host
    input  wire        estop_n,
    output wire [31:0] data,
    output wire [3:0]  sclk,
    output wire [3:0]  rclk,
    output wire        oe_n,
    output wire        sync,
    output wire [2:0]  led
);
    // 25 MHz / 2 * 59 = 737.5 MHz, / 18 = 40.97222 MHz; of that 1024 clocks are a period of 40 011.936 Hz.
    wire clk, feedback, locked;
    (* FREQUENCY_PIN_CLKI = "25", FREQUENCY_PIN_CLKOP = "40.97222" *)
    EHXPLLL #(
        .CLKI_DIV(2), .CLKFB_DIV(1), .FEEDBK_PATH("CLKOS"),
        .CLKOP_ENABLE("ENABLED"), .CLKOP_DIV(18), .CLKOP_CPHASE(17),
        .CLKOS_ENABLE("ENABLED"), .CLKOS_DIV(59), .CLKOS_CPHASE(58)
    ) pll (
        .CLKI(clk_25mhz), .CLKFB(feedback), .CLKOP(clk), .CLKOS(feedback), .LOCK(locked),
        .RST(1'b0), .STDBY(1'b0), .PLLWAKESYNC(1'b0), .ENCLKOP(1'b0), .ENCLKOS(1'b0), .ENCLKOS2(1'b0), .ENCLKOS3(1'b0),
        .PHASESEL0(1'b0), .PHASESEL1(1'b0), .PHASEDIR(1'b0), .PHASESTEP(1'b0), .PHASELOADREG(1'b0)
    );

    wire reset;
    power_up power_up (.clk(clk), .locked(locked), .reset(reset));

    wire [31:0] data_inside;
    wire        shift, latch, oe_n_inside, sync_inside;
    device #(.CARRIER_MHZ(32'd40011936), .FIRST_INCREMENT(16'd3199)) device (
        .clk(clk), .reset(reset), .rxd(ftdi_txd), .txd(ftdi_rxd), .estop_n(estop_n),
        .data(data_inside), .shift(shift), .latch(latch), .oe_n(oe_n_inside), .sync(sync_inside),
        .led_on(led[0]), .led_tripped(led[1]), .led_packet(led[2])
    );
    assign oe_n = oe_n_inside || !locked;

    // All go out through the same kind of register, so that they stay as far apart as they are: SCLK rises in the middle of a clock.
    genvar i;
    generate
        for (i = 0; i < 32; i = i + 1) begin : each_data
            ODDRX1F register (.SCLK(clk), .RST(reset), .D0(data_inside[i]), .D1(data_inside[i]), .Q(data[i]));
        end
        for (i = 0; i < 4; i = i + 1) begin : each_clock
            ODDRX1F sclk_register (.SCLK(clk), .RST(reset), .D0(1'b0), .D1(shift), .Q(sclk[i]));
            ODDRX1F rclk_register (.SCLK(clk), .RST(reset), .D0(latch), .D1(latch), .Q(rclk[i]));
        end
    endgenerate
    ODDRX1F sync_register (.SCLK(clk), .RST(reset), .D0(sync_inside), .D1(sync_inside), .Q(sync));
endmodule

`default_nettype wire
