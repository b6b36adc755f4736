//! A client in plain roslibrust: looks around, cancels a goal of Move Base's action, and reaches another one.
//!
//! roslibrust-client WS_URL '{"near": POSE, "far": POSE}'; prints what it found as one line of JSON.

use std::time::Duration;

use roslibrust::rosbridge::{ClientHandle, Publisher, Subscriber};
use roslibrust::{GraphProvider, Result, RosMessageType};
use serde_json::{json, Value};

roslibrust::generate_ros_types!("interfaces");

use actionlib_msgs::{GoalID, GoalStatus};
use geometry_msgs::{Pose, PoseStamped, PoseWithCovarianceStamped};
use move_base_msgs::{MoveBaseActionFeedback, MoveBaseActionGoal, MoveBaseActionResult, MoveBaseGoal};
use nav_msgs::{OccupancyGrid, Path};
use std_msgs::Header;

/// Return the next message of a topic, or end the program after a minute.
async fn next<T: RosMessageType>(topic: &Subscriber<T>) -> T {
    let message = tokio::time::timeout(Duration::from_secs(60), topic.next()).await;
    message.unwrap_or_else(|_| panic!("no {} came", T::DESCRIPTION.ros_type_name))
}

fn pose(given: &Value) -> Pose {
    serde_json::from_value(given.clone()).expect("a pose")
}

/// Publish a goal below an id. The cloud takes a stamp of zero as now.
async fn send(goals: &Publisher<MoveBaseActionGoal>, id: &str, pose: Pose) -> Result<()> {
    let header = Header { frame_id: "map".to_string(), ..Default::default() };
    let goal = MoveBaseActionGoal {
        goal_id: GoalID { id: id.to_string(), ..Default::default() },
        goal: MoveBaseGoal { target_pose: PoseStamped { header, pose } },
        ..Default::default()
    };
    goals.publish(&goal).await
}

/// Wait for the result of a goal.
async fn end_of(results: &Subscriber<MoveBaseActionResult>, id: &str) -> String {
    let mut status = next(results).await.status;
    while status.goal_id.id != id {
        status = next(results).await.status;
    }
    match status.status {
        GoalStatus::PREEMPTED => "cancelled".to_string(),
        GoalStatus::SUCCEEDED => "succeeded".to_string(),
        other => format!("{other}: {}", status.text),
    }
}

#[tokio::main]
async fn main() -> Result<()> {
    let arguments: Vec<String> = std::env::args().collect();
    let poses: Value = serde_json::from_str(&arguments[2]).expect("the poses as JSON");
    let ros = ClientHandle::new(arguments[1].as_str()).await?;

    let grid = next(&ros.subscribe::<OccupancyGrid>("/map").await?).await;
    let place = next(&ros.subscribe::<PoseWithCovarianceStamped>("/amcl_pose").await?).await.pose.pose.position;
    let plans = ros.subscribe::<Path>("/plan").await?;
    let feedback = ros.subscribe::<MoveBaseActionFeedback>("/move_base/feedback").await?;
    let results = ros.subscribe::<MoveBaseActionResult>("/move_base/result").await?;
    let goals = ros.advertise::<MoveBaseActionGoal>("/move_base/goal").await?;
    let cancel = ros.advertise::<GoalID>("/move_base/cancel").await?;

    send(&goals, "away", pose(&poses["far"])).await?;
    let moving = next(&feedback).await.feedback;
    cancel.publish(&GoalID { id: "away".to_string(), ..Default::default() }).await?;
    let first = end_of(&results, "away").await;
    send(&goals, "there", pose(&poses["near"])).await?;
    let second = end_of(&results, "there").await;

    let topics: Vec<String> = ros.list_topics().await?.into_iter().map(|topic| topic.name).collect();
    // Calls rosapi/service_type once for each service, all at once.
    let services = ros.list_services().await?.into_iter().filter(|service| !service.type_name.is_empty());
    let fields = serde_json::to_value(moving).expect("feedback as JSON");
    let found = json!({
        "topics": topics,
        "services": services.map(|service| service.name).collect::<Vec<_>>(),
        "cells": [grid.info.width * grid.info.height, grid.data.len()],
        "pose": [place.x, place.y],
        "plan": next(&plans).await.poses.len(),
        "feedback": fields.as_object().expect("an object").keys().collect::<Vec<_>>(),
        "ends": [first, second],
    });
    println!("{found}");
    Ok(())
}
