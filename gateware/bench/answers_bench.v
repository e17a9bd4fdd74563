// answers with status, as bytes on the line: COBS, CRC, order, at most four, and their contents.
`include "check.vh"
`include "packets.vh"
module answers_bench;
    `include "bench.vh"
    reg        reset = 1, ask = 0, spoiled = 0, by_line = 0, count = 0, good = 0, silent = 0, old = 0;
    reg        line_open = 0;
    reg  [7:0] flags = 0;
    reg  [5:0] slot = 0;
    reg  [2:0] own = 0;
    reg [31:0] digest = 32'h89ABCDEF;
    reg  [7:0] packet_type = 0, packet_seq = 0, result = 0;
    wire       answered, count_spoiled, count_by_line, about_spoiled, about_old, send, idle;
    wire [4:0] index;
    wire [7:0] value, sent;
    status #(.CARRIER_MHZ(32'h12003456)) status (
        .clk(clk), .reset(reset), .count(count), .good(good), .spoiled(count_spoiled), .spoiled_by_line(count_by_line),
        .address(own), .flags(flags), .slot(slot), .about_spoiled(about_spoiled), .about_old(about_old), .old_seq(8'd99), .digest(digest),
        .packet_type(packet_type), .packet_seq(packet_seq), .result(result), .index(index), .value(value)
    );
    answers answers (
        .clk(clk), .reset(reset), .ask(ask), .answered(answered), .silent(silent),
        .spoiled(spoiled), .spoiled_by_line(by_line), .old_info(old),
        .count_spoiled(count_spoiled), .count_spoiled_by_line(count_by_line), .about_spoiled(about_spoiled), .about_old(about_old),
        .index(index), .value(value), .send(send), .sent(sent), .line_ready(line_open), .idle(idle)
    );

    // Decodes COBS, answer by answer.
    reg [7:0]   left = 0;
    reg [159:0] coming = 0, got [0:15];
    integer     lengths [0:15];
    integer     bytes = 0, answers_seen = 0, on_line = 0;
    reg         whole = 0;
    always @(posedge clk) if (send && line_open) begin
        on_line = on_line + 1;
        if (sent == 0) begin
            `CHECK("the bytes on the line", on_line, bytes + 2)
            lengths[answers_seen] = bytes;
            `CHECK("what is left of a block", left, 8'd0)
            got[answers_seen] = coming;
            answers_seen = answers_seen + 1;
            {bytes, on_line, left} = 0;
        end else if (left == 0) begin
            if (on_line > 1) begin
                coming = {coming[151:0], 8'h00};
                bytes = bytes + 1;
            end
            left = sent - 1;
        end else begin
            coming = {coming[151:0], sent};
            bytes = bytes + 1;
            left = left - 1;
        end
    end

    function [31:0] crc(input [127:0] body);
        integer i, j;
        begin
            crc = 32'hFFFFFFFF;
            for (i = 15; i >= 0; i = i - 1) begin
                crc = crc ^ {24'd0, body[8*i +: 8]};
                for (j = 0; j < 8; j = j + 1) crc = crc[0] ? (crc >> 1) ^ 32'hEDB88320 : crc >> 1;
            end
            crc = ~crc;
            crc = {crc[7:0], crc[15:8], crc[23:16], crc[31:24]};
        end
    endfunction
    function [15:0] old_crc(input [111:0] body);
        integer i, j;
        begin
            old_crc = 16'hFFFF;
            for (i = 13; i >= 0; i = i - 1) begin
                old_crc = old_crc ^ {body[8*i +: 8], 8'h00};
                for (j = 0; j < 8; j = j + 1) old_crc = old_crc[15] ? (old_crc << 1) ^ 16'h1021 : old_crc << 1;
            end
            old_crc = ~old_crc;
        end
    endfunction
    task expect_answer(input integer at, input [119:0] body);
        begin
            `CHECK("the length", lengths[at], 20)
            `CHECK("the body", got[at][159:32], {body, 8'd0})
            `CHECK("the CRC", got[at][31:0], crc({body, 8'd0}))
        end
    endtask
    task expect_old_answer(input integer at, input [111:0] body);
        begin
            `CHECK("the old length", lengths[at], 16)
            `CHECK("the old body", got[at][127:16], body)
            `CHECK("the old CRC", got[at][15:0], old_crc(body))
        end
    endtask
    task question(input [7:0] kind, input [7:0] seq, input [7:0] with);
        begin
            {packet_type, packet_seq, result, good} = {kind, seq, with, 1'b1};
            @(negedge clk) good = 0;
            ask = 1;
            while (!answered) @(negedge clk);
            @(negedge clk) ask = 0;
        end
    endtask
    task spoil(input line);
        begin
            {spoiled, by_line} = {1'b1, line};
            @(negedge clk) spoiled = 0;
            repeat (26) @(negedge clk);
        end
    endtask
    task drain;
        begin
            line_open = 1;
            repeat (1400) @(negedge clk);
            `CHECK("idle", idle, 1'b1)
            line_open = 0;
        end
    endtask

    initial begin
        repeat (2) @(negedge clk);
        reset = 0;
        flags = 8'hD1;
        own = 3'd5;
        slot = 6'd33;
        count = 1;
        repeat (16'h0200) @(negedge clk);
        count = 0;

        question(`TYPE_INFO, 8'd77, `RESULT_OK);
        spoil(0);
        question(`TYPE_ENVELOPE, 8'd0, `RESULT_LENGTH);
        `CHECK("idle with answers to send", idle, 1'b0)
        drain;
        `CHECK("answers", answers_seen, 3)
        expect_answer(0, {8'h81, {5'd0, own}, 8'd77, 8'd0, 8'hD1, 8'd2, 8'd7, 8'd63, `GATEWARE_VERSION, 32'h56340012, 8'd255, 8'd80});
        expect_answer(1, {8'h80, {5'd0, own}, 8'd0, 8'd1, 8'hD1, 8'd33, 8'd0, 16'h0100, 16'h0100, 32'h00020000});
        expect_answer(2, {8'hB0, {5'd0, own}, 8'd0, 8'd2, 8'hD1, 8'd33, 8'd0, 16'h0200, 16'h0100, 32'h00020000});

        // Six are requested while the line is blocked: four are kept, all are counted.
        question(8'hFF, 8'd1, `RESULT_UNKNOWN);
        spoil(1);
        question(`TYPE_STOP, 8'd2, `RESULT_OK);
        spoil(1);
        question(`TYPE_STOP, 8'd3, `RESULT_OK);
        spoil(0);
        drain;
        `CHECK("answers in all", answers_seen, 7)
        expect_answer(3, {8'h7F, {5'd0, own}, 8'd1, 8'd4, 8'hD1, 8'd33, 8'd0, 16'h0300, 16'h0100, 32'h00020000});
        expect_answer(4, {8'h80, {5'd0, own}, 8'd0, 8'd1, 8'hD1, 8'd33, 8'd1, 16'h0300, 16'h0200, 32'h00020000});
        expect_answer(6, {8'h80, {5'd0, own}, 8'd0, 8'd1, 8'hD1, 8'd33, 8'd2, 16'h0400, 16'h0300, 32'h00020000});
        question(`TYPE_STATUS, 8'd4, `RESULT_OK);
        drain;
        expect_answer(7, {8'h82, {5'd0, own}, 8'd4, 8'd0, 8'hD1, 8'd33, 8'd2, 16'h0600, 16'h0400, 32'h00020000});

        // A packet spoiled while an answer is being written is answered after it.
        {packet_type, packet_seq, result, ask} = {`TYPE_STATUS, 8'd5, `RESULT_OK, 1'b1};
        repeat (3) @(negedge clk);
        {spoiled, by_line} = 2'b10;
        @(negedge clk) spoiled = 0;
        while (!answered) @(negedge clk);
        @(negedge clk) ask = 0;
        repeat (40) @(negedge clk);
        drain;
        expect_answer(8, {8'h82, {5'd0, own}, 8'd5, 8'd0, 8'hD1, 8'd33, 8'd2, 16'h0600, 16'h0400, 32'h00020000});
        expect_answer(9, {8'h80, {5'd0, own}, 8'd0, 8'd1, 8'hD1, 8'd33, 8'd2, 16'h0600, 16'h0500, 32'h00020000});
        // INFO of version 1 is answered in its form, between others; and DIGEST with the CRC, unless it was refused.
        old = 1;
        spoil(0);
        old = 0;
        question(`TYPE_DIGEST, 8'd6, `RESULT_OK);
        question(`TYPE_DIGEST, 8'd7, `RESULT_ARGUMENT);
        drain;
        expect_old_answer(10, {8'h81, 8'd99, `RESULT_UNKNOWN, 8'h11, 8'd2, 8'd7, 8'd63, `GATEWARE_VERSION, 32'h56340012, 8'd255, 8'd80});
        expect_answer(11, {8'h87, {5'd0, own}, 8'd6, 8'd0, 8'hD1, 8'd33, 8'd2, 16'h0700, 16'h0600, 32'hEFCDAB89});
        expect_answer(12, {8'h87, {5'd0, own}, 8'd7, 8'd5, 8'hD1, 8'd33, 8'd2, 16'h0800, 16'h0600, 32'h00020000});
        // A silent device counts spoiled packets without answering.
        silent = 1;
        spoil(1);
        old = 1;
        spoil(0);
        old = 0;
        drain;
        `CHECK("answers of a silent device", answers_seen, 13)
        question(`TYPE_STATUS, 8'd8, `RESULT_OK);
        drain;
        expect_answer(13, {8'h82, {5'd0, own}, 8'd8, 8'd0, 8'hD1, 8'd33, 8'd3, 16'h0900, 16'h0800, 32'h00020000});
        `END
    end
endmodule
