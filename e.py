def sub(path, *pairs):
    t=open(path).read()
    for a,b in pairs:
        assert a in t, (path,a)
        t=t.replace(a,b)
    open(path,'w').write(t)
sub('test/test_cmd_keeper.c',
('''    says(7, 0x24);
    says(3, 0);
    says(9, 0x41);
''','''    for (uint8_t id = 100; id < 100 + ROBOT_SERVOS - 3; id++)
        says(id, 0);
    says(7, 0x24);
    says(3, 0);
    says(9, 0x41);
'''),
('''    for (uint8_t id = 10; id < 14; id++)
        says(id, 0);
''','''    for (uint8_t id = 10; id < 10 + ROBOT_SERVOS; id++)
        says(id, 0);
'''),
('servos: 3 and more, held 3,','servos: 18 and more, held 18,'),
)
t=open('test/test_keeper.c').read()
i=t.index('void test_torque_off_goes_on_until_a_line'); j=t.index('/* ---- the crew')
t=t[:i]+'''void test_torque_off_goes_on_until_a_line_that_is_held_low_is_free(void)
{
    meet(1);
    port_fake.low = true;
    lose_link(KEEPER_TORQUE_OFF);
    for (uint16_t i = 0; i < 3000; i++) { // CDS_STOP_TRIES and more
        port_fake.now_us += 3000;
        run(1);
    }
    TEST_ASSERT_EQUAL_UINT8(1, wire.servo[0].torque);
    port_fake.low = false;
    run(10000);
    TEST_ASSERT_FALSE(robot_is_stopping(&robot));
    TEST_ASSERT_EQUAL_UINT8(CDS_OK, robot.stop.result);
    TEST_ASSERT_EQUAL_UINT8(0, wire.servo[0].torque);
}

'''+t[j:]
open('test/test_keeper.c','w').write(t)
