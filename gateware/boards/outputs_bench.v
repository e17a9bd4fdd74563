// The ULX3S' top module with models of its PLL and output registers: the shift registers' signals to the nanosecond,
// a loss of the clock, and the PLL's reset. `boards/bench` runs it for all numbers of phase bits.
`default_nettype none
`timescale 1ns / 1ps

// Locks 2 us after its reset, unless `outputs_bench.lost`.
module EHXPLLL #(
    parameter CLKI_DIV = 1, CLKFB_DIV = 1, FEEDBK_PATH = "", PLLRST_ENA = "", CLKOP_ENABLE = "", CLKOP_DIV = 1, CLKOP_CPHASE = 0,
    parameter CLKOS_ENABLE = "", CLKOS_DIV = 1, CLKOS_CPHASE = 0
) (
    input wire CLKI, CLKFB, RST, STDBY, PLLWAKESYNC, ENCLKOP, ENCLKOS, ENCLKOS2, ENCLKOS3, PHASESEL0, PHASESEL1, PHASEDIR, PHASESTEP, PHASELOADREG,
    output reg CLKOP, output wire CLKOS, output reg LOCK
);
    assign CLKOS = 1'b0;
    initial begin CLKOP = 0; LOCK = 0; end
    always #(20.0 * CLKI_DIV * CLKOP_DIV / CLKOS_DIV) CLKOP = !CLKOP;
    always @(posedge outputs_bench.lost or posedge RST) LOCK = 0;
    always @(negedge LOCK or negedge RST) if (!RST) begin #2000; LOCK = !outputs_bench.lost; end
    initial begin #2000; LOCK = 1; end
endmodule

module ODDRX1F (input wire SCLK, RST, D0, D1, output reg Q);
    reg second;
    always @(posedge SCLK) begin Q <= !RST && D0; second <= !RST && D1; end
    always @(negedge SCLK) Q <= second;
endmodule

module outputs_bench;
    parameter PHASE_BITS = 7;
    parameter OUT_DIVIDE = 18;

    reg lost = 0, clk_25mhz = 0;
    always #20 clk_25mhz = !clk_25mhz;
    wire [31:0] data;
    wire [3:0]  sclk, rclk;
    wire        oe_n, sync, wifi_gpio0, txd;
    wire [2:0]  led;
    top #(.PHASE_BITS(PHASE_BITS), .OUT_DIVIDE(OUT_DIVIDE)) board (
        .clk_25mhz(clk_25mhz), .ftdi_txd(1'b1), .ftdi_rxd(txd), .estop_n(1'b1), .sync_in(1'b0), .address(3'd0),
        .data(data), .sclk(sclk), .rclk(rclk), .oe_n(oe_n), .sync(sync), .led(led), .wifi_gpio0(wifi_gpio0)
    );
    // Outputs are silent: data 0 toggles with every bit instead, the worst case.
    reg bit_now = 0;
    localparam CLOCKS = PHASE_BITS == 5 ? 4 : PHASE_BITS == 6 ? 2 : 1;
    integer clocks = 0;
    wire latch = board.rclk_inside;
    reg  latch_before = 0;
    always @(posedge board.clk) begin
        latch_before <= latch;
        clocks <= latch && !latch_before ? 1 : clocks + 1;
        if (clocks % CLOCKS == 0 || (latch && !latch_before)) bit_now <= !bit_now;
    end

    // The shortest of each, in ns.
    real changed = 0, rose = 0, fell = 0, set_up = 1e9, hold = 1e9, high = 1e9, low = 1e9, to_rclk = 1e9;
    real period = 0, rclk_rose = 0;
    reg  measures = 0;
    always @(bit_now) begin
        if (measures && $realtime - rose < hold) hold = $realtime - rose;
        changed = $realtime;
    end
    always @(posedge sclk[0]) begin
        if (measures && $realtime - changed < set_up) set_up = $realtime - changed;
        if (measures && $realtime - fell < low) low = $realtime - fell;
        rose = $realtime;
    end
    always @(negedge sclk[0]) begin
        if (measures && $realtime - rose < high) high = $realtime - rose;
        fell = $realtime;
    end
    always @(posedge rclk[0]) begin
        if (measures && $realtime - rose < to_rclk) to_rclk = $realtime - rose;
        period = $realtime - rclk_rose;
        rclk_rose = $realtime;
    end

    initial #200000 begin
        $display("%0d phase bits: the PLL is not reset", PHASE_BITS);
        $finish_and_return(1);
    end

    // Required duration of each, in half clocks.
    real half;
    task expect_halves(input [8*12-1:0] name, input real ns, input integer halves);
        if (ns < halves * half - 0.1 || ns > halves * half + 0.1) begin
            $display("%0d phase bits: %0s is %.2f ns, not %0d half clocks of %.2f ns", PHASE_BITS, name, ns, halves, half);
            $finish_and_return(1);
        end
    endtask

    initial begin
        half = 20.0 * 2 * OUT_DIVIDE / 59;
        #30000 measures = 1;
        #60000 measures = 0;
        expect_halves("set-up", set_up, CLOCKS == 1 ? 1 : CLOCKS);
        expect_halves("hold", hold, CLOCKS == 1 ? 1 : CLOCKS);
        expect_halves("SCLK high", high, CLOCKS == 1 ? 1 : 2);
        expect_halves("SCLK low", low, CLOCKS == 1 ? 1 : 2 * CLOCKS - 2);
        expect_halves("SCLK to RCLK", to_rclk, CLOCKS == 1 ? 1 : CLOCKS);
        expect_halves("RCLK period", period, 16 * CLOCKS);
        $display("%0d phase bits: set-up %.1f, hold %.1f, SCLK high %.1f, low %.1f, SCLK to RCLK %.1f ns", PHASE_BITS, set_up, hold, high, low, to_rclk);

        if (board.reset || !oe_n || !wifi_gpio0) begin $display("reset, or outputs on, after power-up"); $finish_and_return(1); end
        lost = 1;
        #100 if (!board.reset || !oe_n) begin $display("a lost clock does not reset"); $finish_and_return(1); end
        // Shortened.
        board.native.power_up.waited = 21'h1FFFE0;
        @(posedge board.pll_reset) lost = 0;
        #5000 if (board.reset || board.pll_reset) begin $display("the clock does not come back after the PLL's reset"); $finish_and_return(1); end
        $finish_and_return(0);
    end
endmodule

`default_nettype wire
