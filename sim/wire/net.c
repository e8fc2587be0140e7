/* SPDX-License-Identifier: MIT */
#include "wire/net.h"

void net_init(struct net *net)
{
    *net = (struct net){.level = true};
}

void net_listen(struct net *net, struct listener *listener)
{
    struct listener **end = &net->listeners;
    while (*end) {
        end = &(*end)->next;
    }
    listener->next = 0;
    *end = listener;
}

void driver_init(struct driver *driver, struct net *net)
{
    *driver = (struct driver){.net = net, .level = true};
}

static void notify_driver(struct net *net, uint64_t time, struct driver *driver)
{
    for (struct listener *l = net->listeners; l; l = l->next) {
        if (l->on_driver) {
            l->on_driver(l->context, time, driver);
        }
    }
}

static void notify_level(struct net *net, uint64_t time)
{
    for (struct listener *l = net->listeners; l; l = l->next) {
        if (l->on_level) {
            l->on_level(l->context, time, net->level);
        }
    }
}

static bool level_at(const struct net *net, uint64_t time)
{
    bool level = net->low == 0;
    switch (net->get_override ? net->get_override(net->context, time) : NET_AS_DRIVEN) {
    case NET_AS_DRIVEN: break;
    case NET_INVERTED: return !level;
    case NET_HIGH: return true;
    case NET_LOW: return false;
    }
    return level;
}

void net_update(struct net *net, uint64_t time)
{
    bool level = level_at(net, time);
    if (level != net->level) {
        net->level = level;
        net->time = time;
        notify_level(net, time);
    }
}

void driver_set(struct driver *driver, uint64_t time, bool enabled, bool level)
{
    struct net *net = driver->net;
    bool switched = enabled != driver->enabled;
    net->low -= driver->enabled && !driver->level;
    net->enabled -= driver->enabled;
    net->exempt -= driver->enabled && driver->exempt;
    driver->enabled = enabled;
    driver->level = level;
    net->low += enabled && !level;
    net->enabled += enabled;
    net->exempt += enabled && driver->exempt;
    if (switched) {
        notify_driver(net, time, driver);
    }
    net_update(net, time);
}

void driver_enable(struct driver *driver, uint64_t time, bool enabled)
{
    if (driver->enabled != enabled) {
        driver_set(driver, time, enabled, driver->level);
    }
}

void driver_level(struct driver *driver, uint64_t time, bool level)
{
    if (driver->level != level) {
        driver_set(driver, time, driver->enabled, level);
    }
}

void driver_exempt(struct driver *driver, bool exempt)
{
    driver->net->exempt -= driver->enabled && driver->exempt;
    driver->exempt = exempt;
    driver->net->exempt += driver->enabled && exempt;
}
