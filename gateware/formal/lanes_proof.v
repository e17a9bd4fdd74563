// ticks, sweep and lanes, reduced (8 channels, 64 clocks per period): no lane reads the bank being written (an
// assertion in lane.v), and the banks never change during a sweep, so that every period is consistent, also on a
// follower that waits at its end or skips its last level. No bit is shifted twice.
`default_nettype none
module lanes_proof (input wire clk, input wire [7:0] phase, input wire [7:0] amplitude, input wire waits, input wire skip, input wire any_mark);
    reg reset = 1'b1;
    always @(posedge clk) reset <= 1'b0;

    wire last, count, boundary, start, open, bank, period_ends;
    wire hold = waits && period_ends;
    reg  mark;
    always @(posedge clk) if (last) mark <= any_mark && !reset;
    wire [5:0] ahead;
    ticks #(.PERIOD_BITS(6), .PHASE_BITS(2), .BOUNDARY(4), .GATE(26)) ticks (
        .clk(clk), .reset(reset), .hold(hold), .skip(skip), .period_ends(period_ends), .last(last), .count(count), .boundary(boundary), .sweep(start), .gate(open),
        .ahead(ahead), .bank(bank)
    );
    wire       write, sync, latch, shift;
    wire [2:0] channel;
    wire [4:0] rise, width;
    sweep #(.CHANNEL_BITS(3), .PHASE_BITS(5)) sweep (
        .clk(clk), .reset(reset), .restart(1'b0), .start(start), .enabled(1'b1), .phase(phase), .amplitude(amplitude), .envelope(8'd255),
        .set_steps(1'b0), .set_phase_step(16'd1), .set_amplitude_step(16'd1),
        .write_offset(1'b0), .write_gain(1'b0), .write_width(1'b0), .write_address(8'd0),
        .offset_written(8'd0), .gain_written(8'd0), .width_written(8'd0), .digesting(1'b0), .digest_address(8'd0),
        .pulse_write(write), .pulse_channel(channel), .pulse_rise(rise), .pulse_width(width)
    );
    lanes #(.PERIOD_BITS(6), .PHASE_BITS(2)) lanes (
        .clk(clk), .reset(reset), .ahead(ahead), .hold(hold), .bank(bank), .mark(mark), .shift(shift),
        .write(write), .write_channel({5'd0, channel}), .write_rise(rise[4:3]), .write_width(width[4:3]), .latch(latch), .sync(sync)
    );

    reg       bank_of_sweep, sweeping = 1'b0, bank_before, latch_before, sync_before, last_before, reset_before = 1'b1;
    reg [3:0] written, shifted;     // pulses of this sweep; bits since the last latch
    always @(posedge clk) begin
        if (start) {sweeping, bank_of_sweep, written} <= {1'b1, bank, 4'd0};
        else if (write) written <= written + 4'd1;
        shifted <= latch && !latch_before ? {3'd0, shift} : shifted + shift;
        if (reset || open) sweeping <= 1'b0;
        {bank_before, latch_before, sync_before, last_before, reset_before} <= {bank, latch, sync, last, reset};
    end
    reg seen = 1'b0;
    always @(posedge clk) seen <= (seen || (latch && !latch_before)) && !reset;
    always @(posedge clk) if (!reset && !reset_before) begin
        if (write) assert (sweeping && bank == bank_of_sweep && channel == written[2:0]);
        if (open) assert (written == 4'd8);
        if (sweeping) assert (bank == bank_of_sweep);
        // A period begins at the registers exactly with a latch.
        if (last_before) assert (latch && !latch_before && sync && !sync_before);
        if (sync && !sync_before) assert (last_before);
        if (latch && !latch_before && seen) assert (shifted == 4'd8);
        cover (last_before && bank && write == 1'b0);
    end
endmodule
