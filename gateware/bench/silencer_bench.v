// silencer against integers: steps within the limit, the shorter way round, and the exact target at the end.
`include "check.vh"
module silencer_bench;
    `include "bench.vh"
    reg  [15:0] phase_step, amplitude_step, phase, amplitude;
    reg  [7:0]  phase_target, amplitude_target;
    wire [15:0] phase_next, amplitude_next;
    silencer silencer (
        .clk(clk), .phase_step(phase_step), .amplitude_step(amplitude_step),
        .phase_target(phase_target), .amplitude_target(amplitude_target),
        .phase(phase), .amplitude(amplitude), .phase_next(phase_next), .amplitude_next(amplitude_next)
    );

    task one;
        integer way, aim, turn, change, phase_expected, amplitude_expected;
        begin
            repeat (2) @(negedge clk);
            turn = phase_step;
            change = amplitude_step;
            way = (phase_target * 256 - phase + 65536) % 65536;
            if (way >= 32768) way = way - 65536;
            if (way > turn) way = turn;
            if (way < -turn) way = -turn;
            phase_expected = (phase + way + 65536) % 65536;
            aim = amplitude_target * 256 - amplitude;
            if (aim > change) aim = change;
            if (aim < -change) aim = -change;
            amplitude_expected = amplitude + aim;
            `CHECK("phase", phase_next, phase_expected[15:0])
            `CHECK("amplitude", amplitude_next, amplitude_expected[15:0])
        end
    endtask

    integer i;
    initial begin
        for (i = 0; i < 50000; i = i + 1) begin
            {phase, amplitude, phase_target, amplitude_target} = {$random, $random};
            phase_step = $random;
            amplitude_step = $random;
            if (i % 3 == 0) phase_step = phase_step >> 6;
            if (i % 5 == 0) amplitude_step = amplitude_step >> 6;
            if (i % 7 == 0) {phase_step, amplitude_step} = 32'hFFFFFFFF;
            // Half a turn away both ways are equally long: it goes down.
            if (i % 11 == 0) phase = {phase_target, 8'h00} + 16'h8000;
            one;
        end
        `END
    end
endmodule
