// safety: silent at first; only ENABLE switches on; the watchdog trips in its exact period and the emergency stop at
// once; tripped until ENABLE or RESET.
`include "check.vh"
module safety_bench;
    `include "bench.vh"
    reg         reset = 1, count = 0, boundary = 0, emergency = 0, good_packet = 0, enable = 0, mute = 0, restart = 0;
    reg  [15:0] watchdog = 0;
    wire        enabled, tripped, forgotten;
    safety safety (
        .clk(clk), .reset(reset), .restart(restart), .count(count), .boundary(boundary), .emergency(emergency), .good_packet(good_packet),
        .enable(enable), .enable_watchdog(watchdog), .mute(mute), .enabled(enabled), .tripped(tripped), .forgotten(forgotten)
    );

    integer forgot = 0;
    always @(posedge clk) if (forgotten) forgot = forgot + 1;

    task periods(input integer n);
        repeat (n) begin
            @(negedge clk) count = 1;
            @(negedge clk) {count, boundary} = 2'b01;
            @(negedge clk) boundary = 0;
        end
    endtask
    task packet;
        begin
            good_packet = 1;
            @(negedge clk) good_packet = 0;
        end
    endtask
    task on(input [15:0] units);
        begin
            packet;
            watchdog = units;
            enable = 1;
            @(negedge clk) enable = 0;
        end
    endtask
    task expect_state(input on, input trip);
        begin
            `CHECK("enabled", enabled, on)
            `CHECK("tripped", tripped, trip)
        end
    endtask

    initial begin
        repeat (2) @(negedge clk);
        reset = 0;
        periods(100);
        packet;
        expect_state(0, 0);
        on(16'd3);
        periods(191);
        expect_state(1, 0);
        packet;
        periods(191);
        expect_state(1, 0);
        periods(1);
        expect_state(0, 1);
        packet;
        periods(500);
        expect_state(0, 1);
        on(16'd0);
        periods(5000);
        expect_state(1, 0);
        mute = 1;
        @(negedge clk) mute = 0;
        expect_state(0, 0);
        on(16'd0);
        emergency = 1;
        expect_state(1, 0);
        @(negedge clk) expect_state(0, 1);
        on(16'd0);
        expect_state(0, 1);
        emergency = 0;
        periods(3);
        expect_state(0, 1);
        restart = 1;
        @(negedge clk) restart = 0;
        expect_state(0, 0);
        // RESET clears the watchdog, but not a pressed stop.
        on(16'd1);
        mute = 1;
        @(negedge clk) mute = 0;
        {restart, emergency} = 2'b11;
        @(negedge clk) {restart, emergency} = 2'b00;
        expect_state(0, 1);
        periods(200);
        expect_state(0, 1);
        on(16'd65535);
        `CHECK("times that it forgot", forgot, 0)
        periods(32767);
        `CHECK("times that it forgot a period too early", forgot, 0)
        periods(1);
        `CHECK("times that it forgot in time", forgot, 1)
        expect_state(1, 0);
        reset = 1;
        @(negedge clk) reset = 0;
        expect_state(0, 0);
        `END
    end
endmodule
