// The device on an XC6SLX9, with an oscillator of 25.6 MHz (the carrier is 40 kHz exactly) or of 50 MHz (39.950 kHz, -0.12 %: no PLL
// of this family makes 512/625). Synthesised with Yosys; not placed, not tried on hardware.
`default_nettype none

module top #(
    parameter OSCILLATOR_KHZ = 25600,   // or 50000
    parameter PHASE_BITS = 7
) (
    input  wire        clk_in,
    input  wire        rxd,
    output wire        txd,
    input  wire        estop_n,
    output wire [31:0] data,
    output wire [3:0]  sclk,
    output wire [3:0]  rclk,
    output wire        oe_n,
    output wire        sync,
    output wire [2:0]  led
);
    // 25.6 MHz * 32 = 819.2 MHz, / 20 = 40.96 MHz; or 50 MHz * 18 = 900 MHz, / 22 = 40.909 MHz, of which 1024 clocks are a period of
    // 39 950.284 Hz. With 8 phase bits twice as fast, and as many periods.
    localparam EXACT = OSCILLATOR_KHZ == 25600;
    localparam HALVES = PHASE_BITS == 8 ? 1 : 2;
    wire clk_pll, clk, clk_n, feedback, locked;
    generate
        if (EXACT) begin : from_25600
            PLL_BASE #(.CLKIN_PERIOD(39.0625), .CLKFBOUT_MULT(32), .CLKOUT0_DIVIDE(10 * HALVES)) pll (
                .CLKIN(clk_in), .CLKFBIN(feedback), .CLKFBOUT(feedback), .CLKOUT0(clk_pll), .LOCKED(locked), .RST(1'b0)
            );
        end else begin : from_50000
            PLL_BASE #(.CLKIN_PERIOD(20.0), .CLKFBOUT_MULT(18), .CLKOUT0_DIVIDE(11 * HALVES)) pll (
                .CLKIN(clk_in), .CLKFBIN(feedback), .CLKFBOUT(feedback), .CLKOUT0(clk_pll), .LOCKED(locked), .RST(1'b0)
            );
        end
    endgenerate
    BUFG clk_buffer (.I(clk_pll), .O(clk));
    assign clk_n = !clk;

    wire reset;
    power_up power_up (.clk(clk), .locked(locked), .reset(reset));

    wire [31:0] data_inside;
    wire        shift, latch, oe_n_inside, sync_inside;
    device #(
        .PHASE_BITS(PHASE_BITS),
        .CARRIER_MHZ(EXACT ? 32'd40000000 : 32'd39950284),
        .FIRST_INCREMENT((EXACT ? 16'd1600 : 16'd1602) * HALVES)
    ) device (
        .clk(clk), .reset(reset), .rxd(rxd), .txd(txd), .estop_n(estop_n),
        .data(data_inside), .shift(shift), .latch(latch), .oe_n(oe_n_inside), .sync(sync_inside),
        .led_on(led[0]), .led_tripped(led[1]), .led_packet(led[2])
    );
    assign oe_n = oe_n_inside || !locked;

    // Registers beside the pins. SCLK rises in the middle of the clock in which they show what is to be shifted.
    (* IOB = "TRUE" *) reg [31:0] data_out;
    (* IOB = "TRUE" *) reg        sync_out;
    (* IOB = "TRUE", keep = "TRUE", equivalent_register_removal = "NO" *) reg [3:0] rclk_out;
    always @(posedge clk) begin
        data_out <= data_inside;
        sync_out <= sync_inside;
        rclk_out <= {4{latch}};
    end
    assign data = data_out;
    assign sync = sync_out;
    assign rclk = rclk_out;

    genvar i;
    generate
        for (i = 0; i < 4; i = i + 1) begin : each
            ODDR2 #(.DDR_ALIGNMENT("C0"), .INIT(1'b0), .SRTYPE("SYNC")) sclk_register (
                .Q(sclk[i]), .C0(clk), .C1(clk_n), .CE(1'b1), .D0(1'b0), .D1(shift), .R(reset), .S(1'b0)
            );
        end
    endgenerate
endmodule

`default_nettype wire
