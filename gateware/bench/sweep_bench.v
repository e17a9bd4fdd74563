// sweep against integers, period by period, with random frames, calibration, envelopes and silencer, on and off.
`include "check.vh"
module sweep_bench;
    `include "bench.vh"
    reg         reset = 1, restart = 0, start = 0, enabled = 0, set_steps = 0;
    reg         write_offset = 0, write_gain = 0, write_width = 0;
    reg  [7:0]  write_address = 0, write_data = 0, envelope = 8'd255, phase, amplitude;
    reg  [15:0] phase_step = 16'h0300, amplitude_step = 16'h0600;
    wire [7:0]  channel, pulse_channel;
    wire        pulse_write, sounds;
    wire [6:0]  pulse_rise, pulse_width;
    sweep sweep (
        .clk(clk), .reset(reset), .restart(restart), .start(start), .enabled(enabled), .channel(channel), .phase(phase), .amplitude(amplitude),
        .envelope(envelope), .set_steps(set_steps), .set_phase_step(phase_step), .set_amplitude_step(amplitude_step),
        .write_offset(write_offset), .write_gain(write_gain), .write_width(write_width),
        .write_address(write_address),
        .offset_written(write_data), .gain_written(write_data), .width_written(write_data),
        .digesting(1'b0), .digest_address(8'd0),
        .pulse_write(pulse_write), .pulse_channel(pulse_channel), .pulse_rise(pulse_rise), .pulse_width(pulse_width),
        .sounds(sounds)
    );
    reg [7:0] phases [0:255], amplitudes [0:255], offsets [0:255], gains [0:255], widths [0:255];
    always @(posedge clk) begin
        phase <= phases[channel];
        amplitude <= amplitudes[channel];
    end

    // The same computation in integers.
    integer state_phase [0:255], state_amplitude [0:255];
    reg [6:0] rises [0:255], highs [0:255];
    reg       heard;
    integer   n, way, aim, turn, change, w;
    task model;
        begin
            heard = enabled;
            turn = phase_step;
            change = amplitude_step;
            if (!enabled && change < 256) change = 256;
            for (n = 0; n < 256; n = n + 1) begin
                way = ((phases[n] + offsets[n]) % 256 * 256 - state_phase[n] + 65536) % 65536;
                if (way >= 32768) way = way - 65536;
                if (way > turn) way = turn;
                if (way < -turn) way = -turn;
                state_phase[n] = (state_phase[n] + way + 65536) % 65536;
                aim = (enabled ? amplitudes[n] * (gains[n] + 1) / 256 * 256 : 0) - state_amplitude[n];
                if (aim > change) aim = change;
                if (aim < -change) aim = -change;
                state_amplitude[n] = state_amplitude[n] + aim;
                if (state_amplitude[n] != 0) heard = 1;
                w = state_amplitude[n] / 256 * (envelope + 1) / 256;
                w = w == 0 ? 0 : widths[w];
                if (w > 128) w = 128;
                highs[n] = (w + 1) / 2;
                rises[n] = (512 + 2 * (state_phase[n] / 256) - 2 * highs[n] + 2) / 4 % 128;
            end
        end
    endtask

    integer written = 0, clocks;
    always @(negedge clk) if (pulse_write) begin
        `CHECK("the channel", pulse_channel, written)
        `CHECK("rise", pulse_rise, rises[pulse_channel])
        `CHECK("width", pulse_width, highs[pulse_channel])
        written = written + 1;
    end
    task period;
        begin
            model;
            written = 0;
            start = 1;
            @(negedge clk) start = 0;
            repeat (282) @(negedge clk);
            `CHECK("channels before the gate opens", written, 256)
            `CHECK("sounds", sounds, heard)
        end
    endtask
    task steps(input [15:0] turning, input [15:0] changing);
        begin
            {phase_step, amplitude_step, set_steps} = {turning, changing, 1'b1};
            @(negedge clk) set_steps = 0;
        end
    endtask
    task frame;
        for (n = 0; n < 256; n = n + 1) {phases[n], amplitudes[n]} = $random;
    endtask

    integer i;
    initial begin
        // The tables' power-up content is written by restore.
        for (i = 0; i < 256; i = i + 1) begin
            {phases[i], amplitudes[i], offsets[i], gains[i]} = {8'd0, 8'd0, 8'd0, 8'd255};
            widths[i] = 8'd255 - i / 2;
            {sweep.offsets.cells[i], sweep.gains.cells[i], sweep.widths.cells[i]} = {offsets[i], gains[i], widths[i]};
            {state_phase[i], state_amplitude[i]} = 0;
        end
        repeat (2) @(negedge clk);
        reset = 0;
        period;
        enabled = 1;
        frame;
        repeat (60) period;
        for (i = 0; i < 256; i = i + 1) begin
            {write_offset, write_address, write_data} = {1'b1, i[7:0], i[7:0] ^ 8'hA5};
            offsets[i] = write_data;
            @(negedge clk) {write_offset, write_gain, write_data} = {1'b0, 1'b1, 8'd255 - i[7:0]};
            gains[i] = write_data;
            @(negedge clk) {write_gain, write_width, write_data} = {1'b0, 1'b1, i[7:0]};
            widths[i] = write_data;
            @(negedge clk) write_width = 0;
        end
        steps(16'hFFFF, 16'hFFFF);
        repeat (10) begin
            frame;
            envelope = $random;
            period;
        end
        steps(16'h0123, 16'h0042);
        repeat (20) period;
        enabled = 0;
        repeat (256) period;
        `CHECK("silent at last", sounds, 1'b0)
        enabled = 1;
        repeat (5) period;
        // RESET clears the silencer's state.
        enabled = 0;
        restart = 1;
        for (i = 0; i < 256; i = i + 1) {state_phase[i], state_amplitude[i]} = 0;
        {phase_step, amplitude_step} = {16'h0300, 16'h0600};
        @(negedge clk) restart = 0;
        period;
        `CHECK("silent after RESET", sounds, 1'b0)
        `END
    end
endmodule
